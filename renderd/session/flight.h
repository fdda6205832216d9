#pragma once

#include <cstdint>

namespace diaphane::render {

/// Flow control for pictures in transit to one viewer. At most `limit` are being encoded or
/// unacknowledged, so that a slow connection holds two pictures and never a queue. The limit is
/// higher only where a long round trip would leave the connection idle
/// (QualityPlan::window_frames). Plain data and arithmetic.
class FlightWindow {
 public:
  static constexpr std::uint64_t kLimit = 2;

  bool room() const { return reserved_ + (sent_ - acknowledged_) < limit_; }
  void set_limit(std::uint64_t limit) { limit_ = limit; }
  /// Reserves a place before encoding. Returns false if there is none.
  bool reserve();
  /// Releases the place of a frame that was dropped.
  void release();
  /// Marks the reserved frame as sent. Returns its sequence number, from 1.
  std::uint64_t depart();
  /// Acknowledges all frames up to `seq`, because the stream preserves order. Ignores numbers that
  /// were not sent. Returns whether this made room.
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
