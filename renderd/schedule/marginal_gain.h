#pragma once

#include "renderd/schedule/policy.h"

namespace diaphane::render {

/// The most error removed per millisecond of the device, from measured error and cost (ADR 0012).
/// Without state: the same views always get the same answer.
///
/// 1. Due sessions first, the earliest deadline before others: a first frame within
///    `deadline_seconds` of the oldest input that it answers, and a quantum for everybody who
///    gains within `patience_seconds` of the last. A deadline that has passed stays where it is,
///    so that it comes before all that follow: nobody starves, whatever the load.
/// 2. Else the session whose next quantum removes most error per second, counted for as long as
///    the picture may be expected to stay, since what is rendered between two inputs of a drag is
///    thrown away with the second.
/// 3. A moving session whose picture was begun just now waits with its next while others gain, as
///    long as its deadline can still be kept. Where the drags of all would take more than
///    `most_drag_share` of the device, that deadline cannot be kept for all, and their frames
///    become fewer instead.
///
/// One quantum at a time; the runner asks until the device is full. A session whose viewer takes no
/// frame has no deadline. The figures were chosen in the simulator (`./diaphane bench
/// schedule`), those for drags by the time to a good picture of everybody at 64 sessions.
class MarginalGain final : public Policy {
 public:
  struct Options {
    QuantumLimits limits;
    double deadline_seconds = 1.0 / 30;
    /// Longer where so many gain that their quanta for patience's sake, of `least_seconds` each,
    /// would take more than `patience_share` of the device.
    double patience_seconds = 2;
    double patience_share = 0.1;
    /// Frames of a moving session: up to `slowest_frame_seconds` apart so that drags take at most
    /// `drag_share` of the device, and further apart still so that they take at most
    /// `most_drag_share`.
    double slowest_frame_seconds = 0.028;
    double drag_share = 0.7;
    double most_drag_share = 0.8;
    /// Input within this long: the session moves.
    double moving_seconds = 0.15;
    /// A picture below this error can be read: reaching it counts as `usable_worth` of error more,
    /// so that of several fresh pictures one after the other gets there, and the mean time is half
    /// of what it is when all arrive together.
    double usable_error = 0.05;
    double usable_worth = 0.2;
    /// How long a picture is expected to stay, seconds: little until input has been silent for
    /// longer than a drag's inputs are apart, then soon as long as a look lasts.
    double silence_seconds = 0.02;
    double stay_growth = 20;
    double shortest_stay = 0.005;
    double longest_stay = 0.3;
  };

  MarginalGain() = default;
  explicit MarginalGain(const Options& options) : options_(options) {}
  std::vector<Quantum> next(std::span<const SessionView> sessions) override;

  /// Error removed per second, weighted as above: what 2. compares.
  double gain(const SessionView& session) const;

 private:
  Options options_;
};

}  // namespace diaphane::render
