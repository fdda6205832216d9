#pragma once

#include <optional>

#include "api/proto/stream.pb.h"
#include "renderd/engine/frame_renderer.h"
#include "renderd/film/error_curve.h"
#include "renderd/session/audience.h"

// Measures how fast the pictures of a session converge.

namespace diaphane::render {

/// Measures the error of the current view, and the metrics of every view. Pictures of a gesture do
/// not count, because they are small and soon replaced.
class Convergence {
 public:
  struct Measured {
    /// Time since the last input. Set once per view, when its error first is at most 5%.
    std::optional<double> seconds_to_five_percent;
    /// The last error of the view that has ended.
    std::optional<double> error_at_rest;
  };

  /// Begins a new view, which replaces the current one. `input`: the time of the newest input that
  /// it contains, or 0 for the first view of a session.
  Measured began(TimePoint input, TimePoint now);
  Measured progressed(const Progress& progress, bool moving, TimePoint now);
  Measured ended();

  const ErrorCurve& curve() const { return curve_; }

 private:
  ErrorCurve curve_;
  TimePoint input_{};
  bool reached_ = false;              // the 5%
  std::optional<double> rest_error_;  // of the current view, if it is at rest
};

diaphane::v1::ErrorCurve to_proto(const ErrorCurve& curve, std::uint64_t epoch);

}  // namespace diaphane::render
