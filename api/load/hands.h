#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "renderd/bench/schedule/trace.h"

namespace diaphane::api::load {

/// Who drags next, so that as many drag at any moment as are wanted. Of a trace of interaction it
/// keeps whose gestures follow whose and how long each of them lasts; a pause lasts until a hand is
/// free. Plain data, no clock.
class Hands {
 public:
  struct Gesture {
    std::size_t session = 0;
    double seconds = 0;
  };
  /// `trace` has at least one session; at most all but one of them move, or the only one.
  Hands(const render::bench::Trace& trace, std::size_t moving);

  std::size_t moving() const { return moving_; }
  /// The first gestures, one a hand.
  std::vector<Gesture> begin();
  /// The gesture of `session` has ended: whose is next. Never one that moves, but its own where
  /// there is no other.
  Gesture after(std::size_t session);

 private:
  Gesture next();

  std::vector<std::vector<double>> lengths_;  // of each session's gestures, seconds
  std::vector<std::size_t> done_;
  std::deque<std::size_t> resting_;  // the longest first
  std::size_t moving_;
};

}  // namespace diaphane::api::load
