#pragma once

#include <cmath>

namespace diaphane {

/// Estimates the share of its device that a session will use (1 is the whole device). The estimate
/// is an exponentially weighted mean of the past use, with a prior worth 30 s of observation: the
/// posterior mean of a rate (docs/adr/0032). A session lasts much longer than its viewer's phases
/// of interaction and rest, so the current load alone says little about the future load.
class ExpectedShare {
 public:
  static constexpr double kMemory = 600;  ///< time constant of the mean, in s
  static constexpr double kPrior = 30;    ///< weight of the prior, in s of observation

  /// Records that the session used `device_seconds` in the last `seconds`.
  void watch(double seconds, double device_seconds) {
    const double kept = std::exp(-seconds / kMemory);
    seconds_ = seconds_ * kept + seconds;
    taken_ = taken_ * kept + device_seconds;
  }
  /// Returns the estimate. `of_anybody` is the prior: the share of one slot, for an unknown
  /// session.
  double value(double of_anybody) const {
    return (kPrior * of_anybody + taken_) / (kPrior + seconds_);
  }

 private:
  double seconds_ = 0, taken_ = 0;
};

}  // namespace diaphane
