#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>

namespace diaphane::render {

/// A token bucket with a burst size and a refill rate per second.
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

/// Limits the rate of slices: fast enough for a user who scrolls, but not unlimited. A request over
/// the limit waits, and the newest one is served when a token is available.
class SliceAllowance {
 public:
  using TimePoint = Bucket::TimePoint;
  /// Slices per second and viewer: two planes that follow a crosshair at 60 frames per second.
  static constexpr double kMostASecond = 120;
  /// Five minutes of uninterrupted scrolling at one slice per displayed frame, which is more than
  /// ten times all slices of 512 x 512 x 512 voxels.
  static constexpr double kInARow = 20'000;
  /// Slices per second after that burst. At this rate, the burst is refilled in about an hour.
  static constexpr double kMostASecondThen = 5;
  /// All guests of a session together, as a multiple of one viewer.
  static constexpr double kGuestsTogether = 4;

  SliceAllowance() : SliceAllowance(1) {}
  explicit SliceAllowance(double viewers)
      : pace_(viewers * kMostASecond, viewers * kMostASecond),
        total_(viewers * kInARow, viewers * kMostASecondThen) {}

  bool empty(TimePoint now);
  /// Takes one token. Precondition: a token is available.
  void take();

 private:
  Bucket pace_, total_;
};

/// The allowances of all viewers of a session, by participant, so that a new connection inherits
/// the previous one's.
class SliceAllowances {
 public:
  /// Participants with an allowance of their own. Further ones share one, because creating
  /// participant ids costs nothing.
  static constexpr std::size_t kMostViewers = 256;

  /// Takes one slice for this participant. Returns false if it must wait.
  bool take(const std::string& participant, bool guest, SliceAllowance::TimePoint now);

 private:
  std::map<std::string, SliceAllowance> by_viewer_;
  SliceAllowance others_;
  SliceAllowance guests_{SliceAllowance::kGuestsTogether};
};

}  // namespace diaphane::render
