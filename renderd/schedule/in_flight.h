#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

namespace diaphane::render {

/// What is under way on one device, and how full it has been. Plain arithmetic; the times given
/// must not fall. A quantum's fill is the share of the device that it keeps busy, 0 to 1.
class InFlight {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `fill`: of its samples; a picture of what is there takes none, and has no rendered().
  void begin(double fill, Time now) {
    pass(now);
    ++count_;
    if (fill > 0) ++rendering_;
    filled_ += fill;
  }
  /// Its samples are there; what else it does takes next to nothing of the device.
  void rendered(double fill, Time now) {
    pass(now);
    --rendering_;
    filled_ = rendering_ == 0 ? 0 : std::max(filled_ - fill, 0.0);
  }
  void end(Time now) {
    pass(now);
    --count_;
  }

  std::size_t count() const { return count_; }
  std::size_t rendering() const { return rendering_; }
  double filled() const { return filled_; }

  /// Integral over time until `now`, seconds, of the part of the device that each of those under
  /// way has when they share it evenly: what lies between two of its values was one's own. All that
  /// is under way together has as long as the device was busy, no more: with the time from begin to
  /// end instead, everybody would pay for the others too.
  double own_seconds(Time now) {
    pass(now);
    return own_seconds_;
  }
  /// With anything under way, until `now`.
  double busy_seconds(Time now) {
    pass(now);
    return busy_seconds_;
  }

 private:
  void pass(Time now) {
    const double seconds = std::max(std::chrono::duration<double>(now - at_).count(), 0.0);
    if (count_ > 0) {
      busy_seconds_ += seconds;
      own_seconds_ += seconds / static_cast<double>(count_);
    }
    at_ = std::max(at_, now);
  }

  Time at_{};
  std::size_t count_ = 0, rendering_ = 0;
  double filled_ = 0, own_seconds_ = 0, busy_seconds_ = 0;
};

/// Whether another quantum goes to the device: until it is full, and then one that waits behind, so
/// that a device which `queues` goes on while the host deals with the end of the one before it. The
/// CPU does not: its threads are the host's.
inline bool room_for_another(const InFlight& in_flight, bool queues) {
  if (!queues) return in_flight.count() == 0 || in_flight.filled() < 1;
  return in_flight.filled() < 1 || in_flight.rendering() < 2;
}

}  // namespace diaphane::render
