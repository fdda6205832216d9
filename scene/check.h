#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "api/proto/scene.pb.h"
#include "common/result.h"
#include "scene/scene.h"

// Helpers shared by the checks of a scene's parts. Fields are named as in the JSON form.

namespace diaphane::scene {

inline constexpr double kLongestDistance = 1e7;  ///< mm
inline constexpr double kBrightest = 1e15;       ///< radiance

/// The first error, or nullopt.
using Complaint = std::optional<Error>;

inline Complaint complain(std::string field, const std::string& what) {
  return Error{ErrorCode::kInvalid, field + " " + what, std::move(field)};
}

/// Every check tests for valid values, because NaN fails all comparisons.
inline Complaint in_range(double value, double low, double high, const std::string& field,
                          const char* what) {
  if (value >= low && value <= high) return {};
  return complain(field, what);
}

inline Complaint check(const diaphane::v1::Vec3& v, const std::string& field) {
  const std::pair<const char*, double> parts[] = {{".x", v.x()}, {".y", v.y()}, {".z", v.z()}};
  for (const auto& [name, value] : parts) {
    if (auto c = in_range(value, -kLongestDistance, kLongestDistance, field + name,
                          "must be from -1e7 to 1e7 mm")) {
      return c;
    }
  }
  return {};
}

inline Complaint check(const diaphane::v1::Rgb& v, double most, const std::string& field,
                       const char* what) {
  const std::pair<const char*, double> parts[] = {{".r", v.r()}, {".g", v.g()}, {".b", v.b()}};
  for (const auto& [name, value] : parts) {
    if (auto c = in_range(value, 0, most, field + name, what)) return c;
  }
  return {};
}

struct Vector {
  double x, y, z;
  double operator[](int axis) const { return axis == 0 ? x : (axis == 1 ? y : z); }
};
inline Vector vector_of(const diaphane::v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double length(Vector a) { return std::sqrt(dot(a, a)); }
inline Vector cross(Vector a, Vector b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Checks all of `scene.lights`.
Complaint check_lights(const diaphane::v1::Scene& scene, PictureCheck check_picture);

}  // namespace diaphane::scene
