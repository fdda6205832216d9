#pragma once

#include <cstdint>

namespace diaphane::render {

/// Messages with pictures on their way to one viewer: at most `limit` are being encoded or not yet
/// acknowledged, so that a slow connection holds two pictures and never a queue of them; more only
/// where a long round trip would leave the connection idle (QualityPlan::window_frames). Plain data
/// and arithmetic.
class FlightWindow {
 public:
  static constexpr std::uint64_t kLimit = 2;

  bool room() const { return reserved_ + (sent_ - acknowledged_) < limit_; }
  void set_limit(std::uint64_t limit) { limit_ = limit; }
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
  std::uint64_t limit_ = kLimit;
  std::uint64_t sent_ = 0;
  std::uint64_t acknowledged_ = 0;
  std::uint64_t reserved_ = 0;
};

}  // namespace diaphane::render
