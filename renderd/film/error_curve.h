#pragma once

#include <cstdint>
#include <vector>

namespace diaphane::render {

/// The state of a picture after a pass.
struct ErrorPoint {
  std::uint64_t samples = 0;  ///< per pixel
  double seconds = 0;         ///< rendering time since the view was set
  double error = 0;           ///< estimated relative RMSE (error.h)
};

/// The error of one view as a function of rendering time and samples. The curve has points for the
/// first and the last pass, and for passes in between that differ by at least 5% in samples. A
/// log-log plot thus shows all of it, and its size grows only with the logarithm of the samples.
class ErrorCurve {
 public:
  static constexpr double kStep = 1.05;

  void clear() { points_.clear(); }
  /// Adds the point of a pass, unless its error is unknown or it has no new samples.
  void add(const ErrorPoint& point);
  const std::vector<ErrorPoint>& points() const { return points_; }

 private:
  std::vector<ErrorPoint> points_;
};

}  // namespace diaphane::render
