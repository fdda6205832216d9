#pragma once

#include "renderd/kernel/features.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"
#include "renderd/math/random.h"

namespace diaphane::render {

/// A camera ray: in voxel indices for tracking, its unit direction in mm for the phase function.
struct CameraRay {
  Ray ray;
  Float3 direction;
};

/// Through the point (x, y) of the picture, in pixels from its upper left corner.
template <Features F, typename Volume>
HOST_DEVICE CameraRay camera_ray(const SceneView<Volume>& scene, float x, float y) {
  const CameraView& c = scene.camera;
  const float a = 2.0f * x / static_cast<float>(scene.width) - 1.0f;
  const float b = 1.0f - 2.0f * y / static_cast<float>(scene.height);
  const Float3 aside = c.right * a + c.up * b;
  CameraRay r;
  r.direction = normalize(c.forward + aside);
  r.ray.origin = (c.start + aside * c.near) * scene.inverse_spacing;
  r.ray.direction = r.direction * scene.inverse_spacing;
  return r;
}

}  // namespace diaphane::render
