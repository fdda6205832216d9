#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "bench/schedule/trace.h"

namespace diaphane::api::load {

/// Chooses the next session to drag, so that a fixed number drags at any moment. From a trace of
/// interaction, it keeps the order of the gestures and their durations. A pause lasts until a hand
/// is free. Plain data without a clock.
class Hands {
 public:
  struct Gesture {
    std::size_t session = 0;
    double seconds = 0;
  };
  /// Takes a trace with at least one session. At least one session rests at any moment, unless
  /// there is only one.
  Hands(const render::bench::Trace& trace, std::size_t moving);

  std::size_t moving() const { return moving_; }
  /// Returns the first gestures, one per hand.
  std::vector<Gesture> begin();
  /// Returns the next gesture after that of `session` has ended. It belongs to a resting session,
  /// or to the same one if there is no other.
  Gesture after(std::size_t session);

 private:
  Gesture next();

  std::vector<std::vector<double>> lengths_;  // seconds, per session and gesture
  std::vector<std::size_t> done_;
  std::deque<std::size_t> resting_;  // the longest-resting session first
  std::size_t moving_;
};

}  // namespace diaphane::api::load
