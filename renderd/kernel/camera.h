#pragma once

#include "renderd/kernel/features.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"
#include "renderd/math/disk.h"
#include "renderd/math/random.h"

namespace diaphane::render {

/// A camera ray in voxel indices for tracking, and its unit direction in mm for the phase function.
struct CameraRay {
  Ray ray;
  Float3 direction;
  float off_centre;  ///< squared distance from the middle of the picture; 1 in the corners
};

/// Returns the ray through the point (x, y) of the picture, in pixels from its upper left corner.
/// `lens` in (0, 1)^2 selects the point on the lens (unused without Feature::kLens). The points are
/// uniform over the lens and weighted equally, so the brightness of a picture does not depend on
/// the lens.
template <Features F, typename Volume>
HOST_DEVICE CameraRay camera_ray(const SceneView<Volume>& scene, float x, float y,
                                 [[maybe_unused]] Random::Pair lens = {0.5f, 0.5f}) {
  const CameraView& c = scene.camera;
  const float a = 2.0f * x / static_cast<float>(scene.width) - 1.0f;
  const float b = 1.0f - 2.0f * y / static_cast<float>(scene.picture_height);
  const Float3 aside = c.right * a + c.up * b;
  Float3 start = c.start + aside * c.near;
  Float3 along = c.forward;
  if constexpr (F.has(Feature::kOrthographic)) {
    along += aside * c.spread;
  } else {
    along += aside;
  }
  if constexpr (F.has(Feature::kLens)) {
    // The ray goes from the lens to the point where the pinhole's ray meets the plane of focus.
    const DiskPoint p = sample_disk(lens.a, lens.b);
    const Float3 on_lens = c.lens_right * p.x + c.lens_up * p.y;
    start += on_lens * c.lens_at_start;
    along += on_lens * -c.lens_bend;
  }
  CameraRay r;
  r.off_centre = 0.5f * (a * a + b * b);
  r.direction = normalize(along);
  r.ray.origin = start * scene.inverse_spacing;
  r.ray.direction = r.direction * scene.inverse_spacing;
  return r;
}

}  // namespace diaphane::render
