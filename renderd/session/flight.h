#pragma once

#include <cstdint>

namespace diaphane::render {

/// Frames on their way to one viewer: at most `kLimit` are being encoded or not yet acknowledged,
/// so that a slow connection holds two pictures and never a queue of them. Plain data and
/// arithmetic.
class FlightWindow {
 public:
  static constexpr std::uint64_t kLimit = 2;

  bool room() const { return reserved_ + (sent_ - acknowledged_) < kLimit; }
  /// Takes a place before encoding; false when there is none.
  bool reserve();
  /// Gives back a place whose frame was dropped.
  void release();
  /// The reserved frame leaves; its sequence number, from 1.
  std::uint64_t depart();
  /// The stream keeps order: an acknowledgement is for all up to `seq`. One for what never left
  /// is ignored. True when room was made.
  bool acknowledge(std::uint64_t seq);
  std::uint64_t sent() const { return sent_; }
  std::uint64_t unacknowledged() const { return sent_ - acknowledged_; }

 private:
  std::uint64_t sent_ = 0;
  std::uint64_t acknowledged_ = 0;
  std::uint64_t reserved_ = 0;
};

}  // namespace diaphane::render
