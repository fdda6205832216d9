#pragma once

#include <cstdint>
#include <optional>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::cli {

/// The limit that was reached first.
enum class StopReason { kSamples, kError, kSeconds };
const char* name_of(StopReason reason);

/// Rendering ends at the first of these limits.
struct StopRule {
  static constexpr std::uint32_t kMostSamples = 1 << 24;

  std::uint32_t samples = kMostSamples;  ///< per pixel
  std::optional<double> error;           ///< estimated error (Progress::error)
  std::optional<double> seconds;         ///< rendering time
};

/// Decides how many samples to render before the next check of clock and error. Pure.
class Pace {
 public:
  explicit Pace(const StopRule& rule);

  /// Returns the number of samples to render now, at least 1. It does not depend on measurements,
  /// because the size of a piece can affect rounding.
  std::uint32_t piece() const;
  /// To be called after a piece, with the total number of samples.
  void advance(std::uint64_t samples);
  /// Returns whether to check the error now. Intervals grow by a quarter, so that estimates cost
  /// little compared with rendering and at most a quarter too much is rendered.
  bool error_is_due() const;
  /// Returns the limit that was reached, if any. `error` is the current error if it was due.
  std::optional<StopReason> reached(double seconds, std::optional<double> error) const;

 private:
  StopRule rule_;
  std::uint64_t done_ = 0;
  std::uint64_t next_look_;
  bool due_ = false;
};

}  // namespace diaphane::render::cli
