#pragma once

#include <cstdint>
#include <optional>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::cli {

/// What was reached first.
enum class StopReason { kSamples, kError, kSeconds };
const char* name_of(StopReason reason);

/// When rendering ends: at whichever of these comes first.
struct StopRule {
  static constexpr std::uint32_t kMostSamples = 1 << 24;

  std::uint32_t samples = kMostSamples;  ///< per pixel
  std::optional<double> error;           ///< estimated (Progress::error)
  std::optional<double> seconds;         ///< of rendering
};

/// Decides how many samples to render before the next look at clock and error. Touches nothing.
class Pace {
 public:
  explicit Pace(const StopRule& rule);

  /// Samples to render now, at least 1. Depends on nothing measured, since the size of a piece can
  /// decide how sums are rounded.
  std::uint32_t piece() const;
  /// After a piece was rendered, with the samples that there are now.
  void advance(std::uint64_t samples);
  /// Whether the error is to be looked at now: at intervals that grow by a quarter, so that
  /// estimating costs little beside rendering, and no more than a quarter too much is rendered.
  bool error_is_due() const;
  /// `error`: as of now when it is due.
  std::optional<StopReason> reached(double seconds, std::optional<double> error) const;

 private:
  StopRule rule_;
  std::uint64_t done_ = 0;
  std::uint64_t next_look_;
  bool due_ = false;
};

}  // namespace diaphane::render::cli
