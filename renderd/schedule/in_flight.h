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

  /// Integral of `filled` over time until `now`, seconds: between two of its values lies how full
  /// the device was, its own quantum included.
  double fill_seconds(Time now) {
    pass(now);
    return fill_seconds_;
  }
  /// With anything under way, until `now`.
  double busy_seconds(Time now) {
    pass(now);
    return busy_seconds_;
  }

 private:
  void pass(Time now) {
    const double seconds = std::max(std::chrono::duration<double>(now - at_).count(), 0.0);
    if (count_ > 0) busy_seconds_ += seconds;
    fill_seconds_ += filled_ * seconds;
    at_ = std::max(at_, now);
  }

  Time at_{};
  std::size_t count_ = 0, rendering_ = 0;
  double filled_ = 0, fill_seconds_ = 0, busy_seconds_ = 0;
};

/// Whether another quantum goes to the device: until it is full, and then one that waits behind, so
/// that a device which `queues` goes on while the host deals with the end of the one before it. The
/// CPU does not: its threads are the host's.
inline bool room_for_another(const InFlight& in_flight, bool queues) {
  if (!queues) return in_flight.count() == 0 || in_flight.filled() < 1;
  return in_flight.filled() < 1 || in_flight.rendering() < 2;
}

/// The share of a quantum's seconds that it would have taken alone, when the device was `mean` full
/// on average while it ran: those that share a full device wait for each other.
inline double own_share(double mean_fill) { return mean_fill > 1 ? 1 / mean_fill : 1; }

}  // namespace diaphane::render
