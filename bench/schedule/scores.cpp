#include "bench/schedule/scores.h"

#include <algorithm>
#include <numeric>

namespace diaphane::render::bench {

void SessionScore::input(double at, bool last) {
  give_up(at);
  if (!oldest_) oldest_ = at;
  last_wanted_ = last;
  last_begun_ = false;
  if (last) waiting_since_ = at;
}

void SessionScore::began(double at) {
  if (!oldest_) return;  // restarted without input, for another size
  queueing_.push_back(at - *oldest_);
  if (!oldest_begun_) oldest_begun_ = oldest_;
  oldest_.reset();
  last_begun_ = last_wanted_;
}

void SessionScore::frame(double at, double error) {
  ++frames_;
  if (oldest_begun_) {
    to_first_.push_back(at - *oldest_begun_);
    oldest_begun_.reset();
  }
  if (last_begun_ && waiting_since_ && error <= kGoodError) {
    to_good_.push_back({at - *waiting_since_, true});
    waiting_since_.reset();
  }
}

void SessionScore::give_up(double at) {
  if (waiting_since_) to_good_.push_back({at - *waiting_since_, false});
  waiting_since_.reset();
}

void SessionScore::hidden(double at) {
  give_up(at);
  oldest_.reset();
  oldest_begun_.reset();
}

void SessionScore::ended(double at) { hidden(at); }

std::optional<double> SessionScore::speed() const {
  double sum = 0;
  std::size_t count = 0;
  for (const ToGood& each : to_good_) {
    // A pause that is too short for any policy is not counted.
    if (!each.reached && each.seconds < alone_) continue;
    sum += each.reached ? std::min(1.0, alone_ / std::max(each.seconds, 1e-9)) : 0;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / static_cast<double>(count);
}

double quantile(std::vector<double> values, double at) {
  if (values.empty()) return 0;
  const auto place = std::min(static_cast<std::size_t>(at * static_cast<double>(values.size())),
                              values.size() - 1);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(place),
                   values.end());
  return values[place];
}

double jain(const std::vector<double>& shares) {
  const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
  const double squares = std::inner_product(shares.begin(), shares.end(), shares.begin(), 0.0);
  return squares > 0 ? sum * sum / (static_cast<double>(shares.size()) * squares) : 1;
}

Scores score(const std::vector<SessionScore>& sessions, const DeviceTime& time, double seconds) {
  std::vector<double> good, first, queueing, speeds;
  double reached = 0;
  Scores scores;
  for (const SessionScore& session : sessions) {
    for (const SessionScore::ToGood& each : session.to_good()) {
      good.push_back(each.seconds);
      reached += each.reached;
    }
    first.insert(first.end(), session.to_first_frame().begin(), session.to_first_frame().end());
    queueing.insert(queueing.end(), session.queueing().begin(), session.queueing().end());
    if (const auto speed = session.speed()) speeds.push_back(*speed);
    scores.frames_per_second += static_cast<double>(session.frames()) / seconds;
  }
  scores.inputs = good.size();
  if (!good.empty()) {
    const auto count = static_cast<double>(good.size());
    scores.to_good_mean = std::accumulate(good.begin(), good.end(), 0.0) / count;
    scores.reached = reached / count;
  }
  scores.to_good_p95 = quantile(good, 0.95);
  scores.first_p50 = quantile(first, 0.5);
  scores.first_p95 = quantile(first, 0.95);
  scores.first_p99 = quantile(first, 0.99);
  scores.queueing_p50 = quantile(queueing, 0.5);
  scores.queueing_p95 = quantile(queueing, 0.95);
  scores.queueing_p99 = quantile(queueing, 0.99);
  scores.fairness = jain(speeds);
  const double busy = time.rendering + time.scenes + time.pictures + time.switching;
  scores.idle = time.idle / std::max(busy + time.idle, 1e-9);
  scores.switching = time.switching / std::max(busy, 1e-9);
  scores.rendering = time.rendering / std::max(busy, 1e-9);
  scores.pictures = time.pictures / std::max(busy, 1e-9);
  return scores;
}

}  // namespace diaphane::render::bench
