#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace diaphane::api::load {

using TimePoint = std::chrono::steady_clock::time_point;

/// Inputs of one viewer that no frame has shown yet. A frame with number n shows all inputs up to
/// n, because a scene is absolute and the newest replaces earlier ones.
class OpenInputs {
 public:
  void sent(std::uint64_t input_seq, TimePoint at) { open_.push_back({input_seq, at}); }
  struct Shown {
    std::vector<double> seconds;  ///< time from each input to this frame, oldest first
  };
  /// Handles a frame. Excludes inputs sent before `from`.
  Shown shown(std::uint64_t input_seq, TimePoint at, TimePoint from);
  /// Returns the age of the inputs without a frame at the end of a run, so that they count as well.
  Shown give_up(TimePoint now, TimePoint from);
  bool empty() const { return open_.empty(); }

 private:
  struct Input {
    std::uint64_t seq;
    TimePoint at;
  };
  std::deque<Input> open_;
};

/// Returns the given percentile, or 0 without values. Reorders the values.
double percentile(std::vector<double>& values, double percent);
double mean(const std::vector<double>& values);

}  // namespace diaphane::api::load
