#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace diaphane::render {

/// What is known of a session when the next quantum is decided. Plain data; times are durations
/// that the runner measured, so that a policy needs no clock.
struct SessionView {
  std::uint64_t session = 0;      ///< the runner's handle
  std::uint64_t samples = 0;      ///< per pixel, of this epoch
  double error = 0;               ///< estimated relative RMSE; infinity while unknown
  double target_error = 0;        ///< converged at or below
  double seconds_per_sample = 0;  ///< measured cost of one sample per pixel; 0: unknown
  double seconds_since_input = 0;
  double seconds_since_frame = 0;  ///< since the last frame was handed to the encoder
  bool visible = true;
  bool wants_frame = true;  ///< its encoder slot is free and the client has room
};

struct Quantum {
  std::uint64_t session = 0;
  std::uint32_t samples = 1;
};

/// Decides the next quantum: a pure function of the views and of its own small state (a turn, a
/// random stream). No clock, no GPU, no lock, no log.
class Policy {
 public:
  virtual ~Policy() = default;
  /// Nothing when no session has anything to gain (all converged or hidden).
  virtual std::optional<Quantum> next(std::span<const SessionView> sessions) = 0;
};

}  // namespace diaphane::render
