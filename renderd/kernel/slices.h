#pragma once

#include "renderd/kernel/clip.h"
#include "renderd/kernel/features.h"
#include "renderd/kernel/medium.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"

namespace diaphane::render {

/// Where a camera ray meets the nearest slice.
struct SliceHit {
  float distance;  ///< mm along the ray
  Float3 place;    ///< voxel indices, exactly in the slice
  bool found;
};

/// Returns the nearest hit of the visible slices inside the volume's box and the clip. `ray` is in
/// voxel indices.
template <Features F, typename Volume>
HOST_DEVICE SliceHit nearest_slice(const SceneView<Volume>& scene, const Ray& ray) {
  const Int3 n = scene.volume.size;
  const Float3 size{static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
  const Float3 at = scene.slices.position;
  SliceHit hit{3.4e38f, {}, false};
  const auto meet = [&](int axis) {
    const float position = at[axis];
    if (!(position >= 0.0f) || ray.direction[axis] == 0.0f) return;
    const float distance = (position - ray.origin[axis]) / ray.direction[axis];
    if (!(distance >= 0.0f && distance < hit.distance)) return;
    Float3 p = ray.at(distance);
    (axis == 0 ? p.x : axis == 1 ? p.y : p.z) = position;
    if (!(p.x >= 0.0f && p.y >= 0.0f && p.z >= 0.0f)) return;
    if (!(p.x <= size.x && p.y <= size.y && p.z <= size.z)) return;
    if (!is_kept<F>(scene, p)) return;
    hit = {distance, p, true};
  };
  meet(0);
  meet(1);
  meet(2);
  return hit;
}

/// Returns the radiance with which a slice shows a voxel value. Exposure and tone curve
/// (film/tone.h) are inverted, so the displayed slice does not depend on them. In grey, the screen
/// shows the level of the window. In colours of the transfer function, it shows opacity times
/// diffuse colour, both linear.
template <typename Volume>
HOST_DEVICE Float3 slice_radiance(const SceneView<Volume>& scene, float value) {
  const SlicesView& s = scene.slices;
  const auto shown_as = [&](float y) {
    return s.curve == ToneCurve::kFilmic ? film_radiance(y) : y;
  };
  if (s.coloured) {
    const float opacity = extinction_at(scene.transfer, value) * s.per_extinction;
    const Float3 colour = albedo_at(scene.transfer, value) * opacity;
    return Float3{shown_as(colour.x), shown_as(colour.y), shown_as(colour.z)} * s.white;
  }
  const float grey = min(max((value - s.black_value) * s.per_value, 0.0f), 1.0f);
  const float radiance = shown_as(powf(grey, 2.2f)) * s.white;
  return {radiance, radiance, radiance};
}

}  // namespace diaphane::render
