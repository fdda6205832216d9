#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

// Wall-clock time, and statistics of several runs.

namespace diaphane::render::bench {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Returns the median. Precondition: at least one value.
inline double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

/// Returns the sample standard deviation (n - 1), or 0 for fewer than two values.
inline double deviation_of(const std::vector<double>& values) {
  if (values.size() < 2) return 0;
  double mean = 0, squared = 0;
  for (const double x : values) mean += x / static_cast<double>(values.size());
  for (const double x : values) squared += (x - mean) * (x - mean);
  return std::sqrt(squared / static_cast<double>(values.size() - 1));
}

}  // namespace diaphane::render::bench
