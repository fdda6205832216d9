#include "renderd/session/link.h"

#include <algorithm>
#include <cmath>

namespace diaphane::render {
namespace {

constexpr double kForgetSeconds = 0.5;
// Seconds. The round trip is the minimum of the current and the previous period.
constexpr double kRoundTripPeriod = 5;
constexpr double kFastest = 1e9;     // bytes per second
constexpr double kLongestBusy = 10;  // seconds, for example after the machine was suspended
// Factors per acknowledgement that arrives as predicted, and per second of an empty pipe before it.
// The second one matters to a slow device, whose pictures are seconds apart.
constexpr double kGrowth = 1.04;
constexpr double kGrowthPerEmptySecond = 2.5;
// Bytes per second: the lower bound of the first estimate. The first acknowledgement also waits
// until the viewer's decoder has started, which makes the link look slower than it is.
constexpr double kAssumed = 250e3;
constexpr double kLateSeconds = 0.015;  // a longer delay means that data queues in the pipe
constexpr double kOverdueSeconds = 0.05;

double seconds_between(LinkEstimate::Time from, LinkEstimate::Time to) {
  return std::max(0.0, std::chrono::duration<double>(to - from).count());
}

}  // namespace

void LinkEstimate::sent(std::uint64_t seq, std::size_t bytes, Time now) {
  if (!under_way_.empty() && seq <= under_way_.back().seq) return;
  under_way_.push_back({seq, bytes, now});
  in_flight_ += bytes;
}

void LinkEstimate::acknowledged(std::uint64_t seq, Time now) {
  if (under_way_.empty() || seq < under_way_.front().seq || seq > under_way_.back().seq) return;
  const Time first_sent = under_way_.front().sent;
  Time last_sent = first_sent;
  std::size_t bytes = 0;
  while (!under_way_.empty() && under_way_.front().seq <= seq) {
    last_sent = under_way_.front().sent;
    bytes += under_way_.front().bytes;
    under_way_.pop_front();
  }
  in_flight_ -= bytes;

  const double taken = seconds_between(last_sent, now);
  const bool first = acknowledged_at_ == Time{};
  const double since_before = first ? kLongestBusy : seconds_between(acknowledged_at_, now);
  const double since_sent = seconds_between(first_sent, now);
  // A message that took less proves that the round trip is shorter than assumed.
  const double alone = since_sent < round_trip_ ? since_sent : since_sent - round_trip_;
  const double size = static_cast<double>(bytes);
  const double longest = first ? size / kAssumed : kLongestBusy;
  const double busy = std::clamp(std::min(since_before, alone), size / kFastest, longest);
  const double before = estimate();
  const double kept = std::exp(-std::min(since_before, 1.0) / kForgetSeconds);
  bytes_ = bytes_ * kept + size;
  busy_ = busy_ * kept + busy;
  const bool late = before > 0 && alone > size / before + kLateSeconds;
  const double empty = std::min(seconds_between(acknowledged_at_, first_sent), 1.0);
  const double growth = std::max(kGrowth, std::pow(kGrowthPerEmptySecond, empty));
  if (!late && !first) busy_ = std::max(busy_ / growth, bytes_ / kFastest);
  acknowledged_at_ = now;
  note_round_trip(taken, bytes, now);
}

void LinkEstimate::note_round_trip(double seconds, std::size_t bytes, Time now) {
  Shortest& current = shortest_[0];
  if (current.since == Time{} || seconds_between(current.since, now) > kRoundTripPeriod) {
    shortest_[1] = current;
    current = {seconds, bytes, now};
  } else if (seconds < current.seconds) {
    current.seconds = seconds;
    current.bytes = bytes;
  }
  const auto empty = [&](const Shortest& one) {
    return std::max(0.0, one.seconds - static_cast<double>(one.bytes) / estimate());
  };
  round_trip_ = empty(current);
  if (shortest_[1].since != Time{}) round_trip_ = std::min(round_trip_, empty(shortest_[1]));
}

double LinkEstimate::bytes_per_second(Time now) const {
  const double known_rate = estimate();
  if (under_way_.empty() || known_rate == 0) return known_rate;
  const Message& oldest = under_way_.front();
  const double waited = std::min(seconds_between(oldest.sent, now) - round_trip_,
                                 seconds_between(std::max(acknowledged_at_, oldest.sent), now));
  const double size = static_cast<double>(oldest.bytes);
  if (waited < size / known_rate + kOverdueSeconds) return known_rate;
  return std::min(known_rate, size / waited);
}

}  // namespace diaphane::render
