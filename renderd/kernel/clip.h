#pragma once

#include "renderd/kernel/features.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"

namespace diaphane::render {

/// The purpose of a ray. Rays to a light may cross matter that the clip hides from the camera
/// (ClipView::light_count).
enum class RayKind { kCamera, kLight };

/// Returns the part of `span` that the clip keeps of a ray in voxel indices. It is a single span,
/// because the kept region is convex, and empty (begin >= end) if nothing is kept.
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
      if (approach == 0.0f) {  // parallel to the plane; avoids a division by 0
        if (left < 0.0f) span.end = span.begin;
      } else if (approach > 0.0f) {
        span.end = min(span.end, left / approach);
      } else {
        span.begin = max(span.begin, left / approach);
      }
    }
  }
  return span;
}

/// Distance beyond a plane of the clip up to which a place counts as kept, mm. The tolerance keeps
/// a slice in a face of the clip box visible despite rounding.
inline constexpr float kClipTolerance = 1e-3f;

/// Returns whether the clip keeps `place`, in voxel indices.
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
