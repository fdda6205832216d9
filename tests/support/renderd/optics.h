#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/renderd/test_scenes.h"

// World space in double precision, for the tests of camera, clip and slices. The kernel works in
// the frame of the volume in single precision.

namespace diaphane::render::test {

/// Rotates a volume by 40 degrees about x and then by 25 degrees about z.
inline volume::Volume tilt(volume::Volume v) {
  const double a = 25 * std::numbers::pi / 180, b = 40 * std::numbers::pi / 180;
  v.header.direction = {std::cos(a),
                        -std::sin(a) * std::cos(b),
                        std::sin(a) * std::sin(b),
                        std::sin(a),
                        std::cos(a) * std::cos(b),
                        -std::cos(a) * std::sin(b),
                        0,
                        std::sin(b),
                        std::cos(b)};
  return v;
}

/// Converts voxel indices to world space.
inline Double3 to_world(const volume::Header& h, Double3 index) {
  double mm[3];
  for (std::size_t i = 0; i < 3; ++i) {
    mm[i] = (index[static_cast<int>(i)] - 0.5 * h.size[i]) * h.spacing[i];
  }
  const auto& d = h.direction;
  return {d[0] * mm[0] + d[1] * mm[1] + d[2] * mm[2], d[3] * mm[0] + d[4] * mm[1] + d[5] * mm[2],
          d[6] * mm[0] + d[7] * mm[1] + d[8] * mm[2]};
}

/// The camera of a scene in world space.
struct WorldCamera {
  Double3 eye, right, up, forward;

  explicit WorldCamera(const diaphane::v1::Camera& c) {
    const auto vector = [](const diaphane::v1::Vec3& v) { return Double3{v.x(), v.y(), v.z()}; };
    eye = vector(c.eye());
    forward = normalize(vector(c.target()) - eye);
    right = normalize(cross(forward, vector(c.up())));
    up = cross(right, forward);
  }
};

/// Interpolates linearly between voxel centres, clamped. `index` is in voxel indices.
inline double value_at(const volume::Volume& volume, Double3 index) {
  const auto& size = volume.header.size;
  double value = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::size_t at[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double q = index[static_cast<int>(axis)] - 0.5;
      const double low = std::floor(q);
      const bool upper = (corner >> axis & 1) != 0;
      weight *= upper ? q - low : 1 - (q - low);
      at[axis] = static_cast<std::size_t>(std::clamp(low + (upper ? 1 : 0), 0.0, size[axis] - 1.0));
    }
    value += weight * volume.voxels[at[0] + size[0] * (at[1] + size[1] * at[2])];
  }
  return value;
}

inline void show(diaphane::v1::Slices::Slice* slice, double position) {
  slice->set_shown(true);
  slice->set_position(position);
}

}  // namespace diaphane::render::test
