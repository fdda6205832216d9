#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>

namespace diaphane::render {

/// So many at once, and so many a second from then on.
class Bucket {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  Bucket(double most, double a_second) : most_(most), a_second_(a_second), left_(most) {}
  void refill(TimePoint now);
  bool empty() const { return left_ < 1; }
  void take() { left_ -= 1; }

 private:
  double most_, a_second_, left_;
  std::optional<TimePoint> counted_at_;
};

/// How many slices are sent: at the pace of a hand that scrolls, and not without end. Who is over
/// it waits; the newest wish is served once there is room.
class SliceAllowance {
 public:
  using TimePoint = Bucket::TimePoint;
  /// One viewer: two planes that follow a crosshair at 60 pictures a second.
  static constexpr double kMostASecond = 120;
  /// Five minutes without a pause at a slice for each picture of the screen, and more than ten
  /// times all slices of 512 x 512 x 512 voxels.
  static constexpr double kInARow = 20'000;
  /// Once those are used up, until they have come back in about an hour.
  static constexpr double kMostASecondThen = 5;
  /// All guests of a session together, as often as one viewer alone.
  static constexpr double kGuestsTogether = 4;

  SliceAllowance() : SliceAllowance(1) {}
  explicit SliceAllowance(double viewers)
      : pace_(viewers * kMostASecond, viewers * kMostASecond),
        total_(viewers * kInARow, viewers * kMostASecondThen) {}

  bool empty(TimePoint now);
  /// Precondition: not empty.
  void take();

 private:
  Bucket pace_, total_;
};

/// Of all who look at one session, by participant: a new connection has what the one before left.
class SliceAllowances {
 public:
  /// Others share one: participants' ids cost nothing.
  static constexpr std::size_t kMostViewers = 256;

  /// One slice for this participant; false: not now.
  bool take(const std::string& participant, bool guest, SliceAllowance::TimePoint now);

 private:
  std::map<std::string, SliceAllowance> by_viewer_;
  SliceAllowance others_;
  SliceAllowance guests_{SliceAllowance::kGuestsTogether};
};

}  // namespace diaphane::render
