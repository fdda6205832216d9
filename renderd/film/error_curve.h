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

/// The error of one view as a function of rendering time and samples. It has a point for the first
/// pass, the last one, and those between whose samples differ by at least 5%. So a log-log plot
/// shows the whole curve, and the number of points grows only with the logarithm of the samples.
class ErrorCurve {
 public:
  static constexpr double kStep = 1.05;

  void clear() { points_.clear(); }
  /// Ignores a pass whose error is unknown, and one without new samples.
  void add(const ErrorPoint& point);
  const std::vector<ErrorPoint>& points() const { return points_; }

 private:
  std::vector<ErrorPoint> points_;
};

}  // namespace diaphane::render
