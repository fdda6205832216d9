#pragma once

#include "renderd/kernel/clip.h"
#include "renderd/kernel/features.h"
#include "renderd/kernel/medium.h"
#include "renderd/kernel/overlay.h"
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

/// Returns the linear colour with which the screen shows a voxel value in a slice. In grey, it is
/// the level of the window. In colours of the transfer function, it is opacity times diffuse
/// colour.
template <typename Volume>
HOST_DEVICE Float3 slice_colour(const SceneView<Volume>& scene, float value) {
  const SlicesView& s = scene.slices;
  if (s.coloured) {
    const float opacity = extinction_at(scene.transfer, value) * s.per_extinction;
    return albedo_at(scene.transfer, value) * opacity;
  }
  const float grey = min(max((value - s.black_value) * s.per_value, 0.0f), 1.0f);
  const float level = powf(grey, 2.2f);
  return {level, level, level};
}

/// Returns the radiance that the screen shows as a linear colour. Exposure and tone curve
/// (film/tone.h) are inverted, so the displayed slice does not depend on them.
template <typename Volume>
HOST_DEVICE Float3 radiance_of_colour(const SceneView<Volume>& scene, Float3 colour) {
  const SlicesView& s = scene.slices;
  const auto shown_as = [&](float y) {
    return s.curve == ToneCurve::kFilmic ? film_radiance(y) : y;
  };
  return Float3{shown_as(colour.x), shown_as(colour.y), shown_as(colour.z)} * s.white;
}

template <typename Volume>
HOST_DEVICE Float3 slice_radiance(const SceneView<Volume>& scene, float value) {
  return radiance_of_colour(scene, slice_colour(scene, value));
}

/// Returns the radiance of a slice at a place (voxel indices). The second scan lies over the first
/// in the colours of its own transfer function.
template <Features F, typename Volume>
HOST_DEVICE Float3 slice_radiance_at(const SceneView<Volume>& scene, Float3 place,
                                     [[maybe_unused]] SharesOf<F> shares) {
  const float value = scene.volume.at(place);
  if constexpr (F.has(Feature::kOverlay)) {
    const OverlayView<Volume>& o = scene.overlay;
    const float below = o.split ? shares.first : o.first_in_slices;
    const float above = o.split ? shares.second : o.second_in_slices;
    Float3 colour = slice_colour(scene, value) * below;
    const Float3 there = in_second(o.map, place);
    if (above > 0.0f && is_inside(o.volume.size, there)) {
      const float other = o.volume.at(there);
      const float opacity = above * extinction_at(o.transfer, other) * o.per_extinction;
      colour = colour * (1.0f - opacity) + albedo_at(o.transfer, other) * opacity;
    }
    return radiance_of_colour(scene, colour);
  } else {
    return slice_radiance(scene, value);
  }
}

}  // namespace diaphane::render
