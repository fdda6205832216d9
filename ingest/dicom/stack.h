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

/// Where a slice of the volume comes from.
struct Source {
  double slice = 0;               ///< place in Stack::order, whole or between two
  std::array<double, 2> shift{};  ///< mm along row and column, from the first slice's corner to its
                                  ///< own
};

/// How positions lie along a normal, and what volume they make.
struct Stack {
  bool is_volume = false;
  std::string code, text;          ///< why they make none
  std::vector<std::size_t> order;  ///< indices of the positions by rising distance along the normal
  double spacing = 0;              ///< mm, of the volume's slices
  double jitter = 0;               ///< mm, the largest distance of a slice from its place
  double tilt = 0;          ///< degrees between the stack and the slices' normal, if straightened
  std::size_t missing = 0;  ///< slices that are filled in
  std::array<double, 2> varying{};  ///< mm, the least and the largest distance, if they vary
  /// The slices of the volume, one a `spacing`; empty when the slices are it as they are.
  std::vector<Source> sources;
};

/// Pure (design: ingest, cases 2 to 6, 8 and 11). Precondition: at least two positions. `pixel` is
/// the smaller pixel spacing, mm.
Stack arrange(const std::vector<Vec3>& positions, const Axes& axes, double pixel);

}  // namespace diaphane::dicom
