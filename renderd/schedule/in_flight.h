#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>

#include "renderd/schedule/policy.h"

namespace diaphane::render {

/// Tracks the quanta that one device is executing and how much of it they occupy. It is plain
/// arithmetic without a clock: callers pass times, which must not decrease. The fill of a quantum
/// is the share of the device that its samples occupy, 0 to 1.
class InFlight {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Begins a quantum. `fill` is 0 for a quantum that only makes a picture from the existing
  /// samples; rendered() is not called for it. Quanta of a lower `precedence` pause until this one
  /// ends. The maximum is kHighestPrecedence. `spare`: it uses time that nothing else needs.
  void begin(double fill, Time now, unsigned precedence = 0, bool spare = false) {
    pass(now);
    ++count_;
    if (spare) ++spare_;
    ++levels_[precedence].count;
    if (fill > 0) ++rendering_;
    filled_ += fill;
  }
  /// Ends the sampling of a quantum. The rest of its work takes almost nothing of the device.
  void rendered(double fill, Time now) {
    pass(now);
    --rendering_;
    filled_ = rendering_ == 0 ? 0 : std::max(filled_ - fill, 0.0);
  }
  /// Raises the precedence of a quantum. Returns what has to be added to its own_seconds() from
  /// then on, so that they continue from their earlier value.
  double raise(Time now, unsigned from, unsigned to) {
    pass(now);
    --levels_[from].count;
    ++levels_[to].count;
    return levels_[from].own_seconds - levels_[to].own_seconds;
  }
  /// `precedence` and `spare` are those of begin() and raise().
  void end(Time now, unsigned precedence = 0, bool spare = false) {
    pass(now);
    --count_;
    if (spare) --spare_;
    --levels_[precedence].count;
  }

  std::size_t count() const { return count_; }
  std::size_t rendering() const { return rendering_; }
  /// Returns the highest precedence of the quanta in flight; 0 if there are none.
  unsigned highest() const {
    unsigned level = kHighestPrecedence;
    while (level > 0 && levels_[level].count == 0) --level;
    return level;
  }
  double filled() const { return filled_; }

  /// Returns the integral until `now`, in seconds, of the share of the device that one quantum of
  /// `precedence` has. The quanta of the highest precedence in flight share the device evenly, and
  /// those of lower precedences pause, so their integrals do not advance. The difference between
  /// two values is the device time of a quantum between them. The device times of all quanta add up
  /// to the time during which the device was busy. The time from begin to end would also charge
  /// each quantum for the others.
  double own_seconds(Time now, unsigned precedence = 0) {
    pass(now);
    return levels_[precedence].own_seconds;
  }
  /// Returns the seconds until `now` during which at least one quantum was in flight.
  double busy_seconds(Time now) {
    pass(now);
    return busy_seconds_;
  }
  /// Returns the part of busy_seconds() during which not all quanta used spare time.
  double needed_seconds(Time now) {
    pass(now);
    return needed_seconds_;
  }

 private:
  void pass(Time now) {
    const double seconds = std::max(std::chrono::duration<double>(now - at_).count(), 0.0);
    if (count_ > 0) {
      busy_seconds_ += seconds;
      if (count_ > spare_) needed_seconds_ += seconds;
      Level& working = levels_[highest()];
      working.own_seconds += seconds / static_cast<double>(working.count);
    }
    at_ = std::max(at_, now);
  }

  Time at_{};
  struct Level {
    std::size_t count = 0;
    double own_seconds = 0;
  };

  std::size_t count_ = 0, spare_ = 0, rendering_ = 0;
  std::array<Level, kHighestPrecedence + 1> levels_{};
  double filled_ = 0, busy_seconds_ = 0, needed_seconds_ = 0;
};

/// Returns whether the device should get another quantum. Every device gets quanta until it is
/// full. One that `queues` then gets one more, which waits behind the others, so that the device
/// stays busy while the host handles the end of a quantum. The CPU engine does not queue, because
/// it renders on the threads of the host.
inline bool room_for_another(const InFlight& in_flight, bool queues) {
  if (!queues) return in_flight.count() == 0 || in_flight.filled() < 1;
  return in_flight.filled() < 1 || in_flight.rendering() < 2;
}

}  // namespace diaphane::render
