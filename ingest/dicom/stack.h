#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace diaphane::dicom {

using Vec3 = std::array<double, 3>;

inline double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// Unit axes of a slice: along a row, along a column, and the normal row x column, so that any
/// stack sorted along the normal is right-handed.
struct Axes {
  Vec3 row{}, column{}, normal{};
};
/// Nothing sensible (false) when the two given directions are not unit length and at right angles.
bool make_axes(const std::array<double, 6>& orientation, Axes& axes);

/// How positions lie along a normal.
struct Stack {
  bool regular = false;
  std::string code, text;          ///< why it is not
  std::vector<std::size_t> order;  ///< indices of the positions by rising distance along the normal
  double spacing = 0;              ///< mm, (last - first) / (n - 1)
  double jitter = 0;               ///< mm, the largest distance of a slice from its place
};

/// Precondition: at least two positions. `pixel` is the smaller pixel spacing, mm.
Stack arrange(const std::vector<Vec3>& positions, const Axes& axes, double pixel);

}  // namespace diaphane::dicom
