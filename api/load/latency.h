#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace diaphane::api::load {

using TimePoint = std::chrono::steady_clock::time_point;

/// Inputs of one viewer that no frame has shown yet. A frame that carries number n shows all inputs
/// up to n: a scene is absolute, and the newest replaces those before it.
class OpenInputs {
 public:
  void sent(std::uint64_t input_seq, TimePoint at) { open_.push_back({input_seq, at}); }
  struct Shown {
    std::vector<double> seconds;  ///< from each input to this frame, the oldest first
  };
  /// A frame came. Of inputs sent before `from` nothing is told.
  Shown shown(std::uint64_t input_seq, TimePoint at, TimePoint from);
  /// Those still without a frame, with their age: a run ends, and they must not be forgotten.
  Shown give_up(TimePoint now, TimePoint from);
  bool empty() const { return open_.empty(); }

 private:
  struct Input {
    std::uint64_t seq;
    TimePoint at;
  };
  std::deque<Input> open_;
};

/// What lies above `percent` of the values; 0 of none. Reorders them.
double percentile(std::vector<double>& values, double percent);
double mean(const std::vector<double>& values);

}  // namespace diaphane::api::load
