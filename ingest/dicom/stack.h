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

/// Returns a number and its noun, such as "1 slice" and "2 slices".
inline std::string counted(std::size_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

/// Unit axes of a slice along a row, along a column, and along the normal row x column. Any stack
/// sorted along the normal is therefore right-handed.
struct Axes {
  Vec3 row{}, column{}, normal{};
};
/// Computes the axes of a slice. Returns false unless `orientation` is two perpendicular unit
/// vectors.
bool make_axes(const std::array<double, 6>& orientation, Axes& axes);

/// Source of a slice of the volume.
struct Source {
  double slice = 0;  ///< index in Stack::order, fractional between two slices
  std::array<double, 2>
      shift{};  ///< mm along row and column, from the corner of the first slice to this one's
};

/// How positions lie along a normal, and the volume that they form.
struct Stack {
  bool is_volume = false;
  std::string code, text;          ///< why they form no volume
  std::vector<std::size_t> order;  ///< indices of the positions by rising distance along the normal
  double spacing = 0;              ///< mm, of the volume's slices
  double jitter = 0;               ///< mm, the largest distance of a slice from its place
  double tilt = 0;  ///< degrees between the stack and the normal of the slices, if straightened
  std::size_t missing = 0;          ///< number of interpolated slices
  std::array<double, 2> varying{};  ///< mm, smallest and largest distance if they vary
  /// The slices of the volume, one per `spacing`. Empty if the slices form it unchanged.
  std::vector<Source> sources;
};

/// Plans a volume from slice positions. Pure (design: ingest, cases 2 to 6, 8 and 11).
/// Precondition: at least two positions. `pixel` is the smaller pixel spacing in mm.
Stack arrange(const std::vector<Vec3>& positions, const Axes& axes, double pixel);

}  // namespace diaphane::dicom
