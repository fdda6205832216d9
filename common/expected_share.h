#pragma once

#include <cmath>

namespace diaphane {

/// What a session is expected to take of its device from now on; 1: all of it. The mean of what it
/// took, the longer ago the less; at first what is expected of anybody, as if he had been watched
/// for a while: the posterior mean of a rate (docs/adr/0032). Who is placed stays for long against
/// the seconds that he looks and rests by turns, so the moment's load says little of what comes.
class ExpectedShare {
 public:
  static constexpr double kMemory = 600;  ///< s
  static constexpr double kPrior = 30;    ///< s

  /// It took `device_seconds` in the last `seconds`.
  void watch(double seconds, double device_seconds) {
    const double kept = std::exp(-seconds / kMemory);
    seconds_ = seconds_ * kept + seconds;
    taken_ = taken_ * kept + device_seconds;
  }
  /// `of_anybody`: the share of whom nothing is known; a slot's.
  double value(double of_anybody) const {
    return (kPrior * of_anybody + taken_) / (kPrior + seconds_);
  }

 private:
  double seconds_ = 0, taken_ = 0;
};

}  // namespace diaphane
