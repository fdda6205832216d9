#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/result.h"
#include "volume/region.h"

namespace diaphane::volume {

/// Maximum number of points of a curve.
inline constexpr std::size_t kMostCurvePoints = 64;

/// A smooth curve through points in world coordinates (slices.h), measured by arc length: a
/// centripetal Catmull-Rom spline. Consecutive points that coincide count as one.
///
/// A rotation-minimising frame moves along the curve (double reflection, Wang et al. 2008). Its
/// first direction across is that of the patient axis that is least parallel to the curve. Of
/// equally parallel ones, the feet come before the left and the left before the back.
class Curve {
 public:
  struct Frame {
    Vector place{};
    Vector along{};   ///< unit tangent
    Vector across{};  ///< unit vector, perpendicular to `along`
  };

  /// Returns kInvalid and the field "points" if numbers are not finite or out of range, if there
  /// are too many points, or if fewer than two of them differ.
  static Result<Curve> through(std::span<const Vector> points);

  double length() const { return nodes_.back().arc; }  ///< mm
  /// Returns the frame at an arc length, limited to the curve.
  Frame at(double arc) const;

 private:
  /// A point of the dense polyline that measures the curve.
  struct Node {
    double parameter = 0;  ///< segment of the spline, and the position within it
    double arc = 0;        ///< mm from the start
    Frame frame;
  };
  /// A segment of the spline in Hermite form.
  struct Segment {
    Vector from{}, to{};
    Vector leaving{}, arriving{};  ///< derivatives at both ends
  };

  Vector place_at(double parameter) const;
  Vector derivative_at(double parameter) const;
  void find_tangents();
  void turn_frames();
  Vector first_across() const;

  std::vector<Segment> segments_;
  std::vector<Node> nodes_;
};

}  // namespace diaphane::volume
