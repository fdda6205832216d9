#pragma once

#include <chrono>
#include <cstdint>
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
  /// May leave a debt, which the next ones wait for.
  void take(double cost = 1) { left_ -= cost; }

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
  /// Samples of an oblique slice or a slab that cost as much as one slice of a stack.
  static constexpr double kSamplesPerToken = 512 * 512;
  /// All guests of a session together, as a multiple of one viewer.
  static constexpr double kGuestsTogether = 4;

  SliceAllowance() : SliceAllowance(1) {}
  explicit SliceAllowance(double viewers)
      : pace_(viewers * kMostASecond, viewers * kMostASecond),
        total_(viewers * kInARow, viewers * kMostASecondThen) {}

  bool empty(TimePoint now);
  /// Precondition: a token is available. A slice that costs more leaves a debt.
  void take(double cost = 1);

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
  /// Charges the samples of an oblique slice, beyond the token that it has taken.
  void charge(const std::string& participant, bool guest, std::uint64_t samples);

 private:
  SliceAllowance& allowance_of(const std::string& participant);

  std::map<std::string, SliceAllowance> by_viewer_;
  SliceAllowance others_;
  SliceAllowance guests_{SliceAllowance::kGuestsTogether};
};

}  // namespace diaphane::render
