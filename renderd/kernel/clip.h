#pragma once

#include "renderd/kernel/features.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"

namespace diaphane::render {

/// What a ray is for: light may go where the camera does not look (ClipView::light_count).
enum class RayKind { kCamera, kLight };

/// The part of `span` that the clip leaves of a ray in voxel indices. One span: what is kept is
/// convex. Empty (begin >= end) where nothing is left.
template <Features F, typename Volume>
HOST_DEVICE Span clip_span([[maybe_unused]] const SceneView<Volume>& scene,
                           [[maybe_unused]] const Ray& ray, Span span,
                           [[maybe_unused]] RayKind kind) {
  if constexpr (F.has(Feature::kClip)) {
    if constexpr (!F.has(Feature::kClipLight)) {
      if (kind == RayKind::kLight) return span;
    }
    const ClipView& clip = scene.clip;
    const std::uint32_t count = kind == RayKind::kCamera ? clip.count : clip.light_count;
    for (std::uint32_t i = 0; i < count; ++i) {
      const HalfSpace& h = clip.kept[i];
      const float left = h.most - dot(h.normal, ray.origin);
      const float approach = dot(h.normal, ray.direction);
      if (approach == 0.0f) {  // along the plane: never a division by it
        if (left < 0.0f) span.end = span.begin;
      } else if (approach > 0.0f) {
        span.end = smaller(span.end, left / approach);
      } else {
        span.begin = larger(span.begin, left / approach);
      }
    }
  }
  return span;
}

/// How far beyond a plane of the clip a place still counts as kept, mm: a slice in a face of the
/// clip box is seen, wherever rounding puts it.
inline constexpr float kClipTolerance = 1e-3f;

/// `place` in voxel indices.
template <Features F, typename Volume>
HOST_DEVICE bool is_kept([[maybe_unused]] const SceneView<Volume>& scene,
                         [[maybe_unused]] Float3 place) {
  if constexpr (F.has(Feature::kClip)) {
    for (std::uint32_t i = 0; i < scene.clip.count; ++i) {
      const HalfSpace& h = scene.clip.kept[i];
      if (dot(h.normal, place) > h.most + kClipTolerance) return false;
    }
  }
  return true;
}

}  // namespace diaphane::render
