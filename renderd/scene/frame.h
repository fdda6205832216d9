#pragma once

#include "api/proto/scene.pb.h"
#include "renderd/math/vector.h"
#include "volume/volume.h"

namespace diaphane::render {

inline Double3 vector_of(const diaphane::v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Float3 colour_of(const diaphane::v1::Rgb& c) {
  return to_float(Double3{c.r(), c.g(), c.b()});
}

/// Transforms world space (origin at the centre of the box, axes of the patient) to the volume's
/// frame (origin at the corner of voxel (0,0,0), axes of the voxels). Both are in mm.
struct WorldToFrame {
  Double3 axes[3];  ///< voxel axes in world space
  Double3 extent;   ///< size of the box

  explicit WorldToFrame(const volume::Header& h) {
    for (std::size_t i = 0; i < 3; ++i) {
      axes[i] = {h.direction[i], h.direction[3 + i], h.direction[6 + i]};
    }
    extent = {h.size[0] * h.spacing[0], h.size[1] * h.spacing[1], h.size[2] * h.spacing[2]};
  }
  Double3 direction(Double3 w) const { return {dot(axes[0], w), dot(axes[1], w), dot(axes[2], w)}; }
  Double3 point(Double3 w) const { return direction(w) + extent * 0.5; }
  /// Returns a corner of the box in the frame; `which` is 0 to 7.
  Double3 corner(unsigned which) const {
    return {(which & 1) != 0 ? extent.x : 0.0, (which & 2) != 0 ? extent.y : 0.0,
            (which & 4) != 0 ? extent.z : 0.0};
  }
};

}  // namespace diaphane::render
