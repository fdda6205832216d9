#pragma once

#include <array>
#include <cmath>

namespace diaphane::volume {

/// Returns the distance of `p` from the middle of an ellipsoid, relative to that of its surface.
inline double ellipsoid(const std::array<double, 3>& p, const std::array<double, 3>& middle,
                        const std::array<double, 3>& half) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum += std::pow((p[i] - middle[i]) / half[i], 2);
  return std::sqrt(sum);
}

/// The same for an ellipse around the origin.
inline double ellipse(double x, double y, double half_x, double half_y) {
  return std::hypot(x / half_x, y / half_y);
}

}  // namespace diaphane::volume
