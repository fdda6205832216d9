#include "bench/load/latency.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace diaphane::api::load {
namespace {

double seconds_between(TimePoint from, TimePoint to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

OpenInputs::Shown OpenInputs::shown(std::uint64_t input_seq, TimePoint at, TimePoint from) {
  Shown shown;
  while (!open_.empty() && open_.front().seq <= input_seq) {
    if (open_.front().at >= from) shown.seconds.push_back(seconds_between(open_.front().at, at));
    open_.pop_front();
  }
  return shown;
}

OpenInputs::Shown OpenInputs::give_up(TimePoint now, TimePoint from) {
  Shown left;
  for (const Input& input : open_) {
    if (input.at >= from) left.seconds.push_back(seconds_between(input.at, now));
  }
  open_.clear();
  return left;
}

double percentile(std::vector<double>& values, double percent) {
  if (values.empty()) return 0;
  const double rank = std::ceil(percent / 100 * static_cast<double>(values.size())) - 1;
  const auto place = static_cast<std::ptrdiff_t>(std::clamp(rank, 0.0, double(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<std::size_t>(place)];
}

double mean(const std::vector<double>& values) {
  if (values.empty()) return 0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace diaphane::api::load
