#pragma once

#include "renderd/kernel/camera.h"
#include "renderd/kernel/clip.h"
#include "renderd/kernel/environment.h"
#include "renderd/kernel/features.h"
#include "renderd/kernel/overlay.h"
#include "renderd/kernel/slices.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"

namespace diaphane::render {

/// The segment of a camera ray that an estimator has to handle, after the clip and the slices were
/// applied.
struct PrimaryHit {
  Span span;          ///< part of the ray that may contain matter; empty if there is none
  Float3 background;  ///< radiance of the ray if it does not collide
  bool slice;         ///< whether `background` is a slice
};

template <Features F, typename Volume>
HOST_DEVICE PrimaryHit primary_hit(const SceneView<Volume>& scene, const CameraRay& camera,
                                   [[maybe_unused]] SharesOf<F> shares) {
  const Ray& ray = camera.ray;
  PrimaryHit primary{clip(ray, scene.grid.occupied, Span{0.0f, 3.4e38f}),
                     escape_radiance<F>(scene, camera.direction, camera.off_centre), false};
  primary.span = clip_span<F>(scene, ray, primary.span, RayKind::kCamera);
  if constexpr (F.has(Feature::kSlices)) {
    const SliceHit hit = nearest_slice<F>(scene, ray);
    if (hit.found) {
      primary.span.end = min(primary.span.end, hit.distance);
      primary.background = slice_radiance_at<F>(scene, hit.place, shares);
      primary.slice = true;
    }
  }
  return primary;
}

}  // namespace diaphane::render
