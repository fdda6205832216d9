#pragma once

#include "renderd/film/guides.h"
#include "renderd/kernel/medium.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"

namespace diaphane::render {

/// Where the ray is taken to be opaque.
inline constexpr float kGuidesEnd = 0.02f;

/// Gradient of the voxel values in mm by central differences over two voxels, made a unit vector;
/// zero where there is none.
template <typename Volume>
HOST_DEVICE Float3 gradient_direction(const SceneView<Volume>& scene, Float3 p) {
  const Volume& v = scene.volume;
  const Float3 gradient = Float3{v.at({p.x + 1.0f, p.y, p.z}) - v.at({p.x - 1.0f, p.y, p.z}),
                                 v.at({p.x, p.y + 1.0f, p.z}) - v.at({p.x, p.y - 1.0f, p.z}),
                                 v.at({p.x, p.y, p.z + 1.0f}) - v.at({p.x, p.y, p.z - 1.0f})} *
                          scene.inverse_spacing;
  const float squared = dot(gradient, gradient);
  if (!(squared > 0.0f)) return {0.0f, 0.0f, 0.0f};
  return gradient * (1.0f / sqrtf(squared));
}

/// What is seen along `ray` within `span` (inside the grid's box), by steps of a voxel. Draws no
/// random number: one collision of a tracker is anywhere along the ray, so that guides of a few
/// collisions are as noisy as the picture they are to smooth. Biased by the steps, which harms
/// nobody: a guide says what is alike.
template <typename Volume>
HOST_DEVICE Guides guides_along(const SceneView<Volume>& scene, const Ray& ray, Span span) {
  Guides sum{};
  if (!(span.begin < span.end)) return sum;
  const Float3 d = ray.direction;
  const float per_step =
      larger(larger(fabsf(d.x), fabsf(d.y)), fabsf(d.z));  // voxels per mm along the fastest axis
  float clear = 1.0f, most = 0.0f, most_at = span.begin;
  CellWalk walk(ray, span, scene.grid);
  do {
    if (!(scene.grid.cells[walk.cell()].majorant > 0.0f)) continue;
    const float length = walk.end() - walk.begin();
    const std::int32_t steps =
        1 + static_cast<std::int32_t>(smaller(length * per_step, 4.0f * kCellSize));
    const float step = length / static_cast<float>(steps);
    for (std::int32_t i = 0; i < steps && clear > kGuidesEnd; ++i) {
      const float t = walk.begin() + (static_cast<float>(i) + 0.5f) * step;
      const float value = scene.volume.at(ray.at(t));
      const float depth = extinction_at(scene.transfer, value) * step;
      if (!(depth > 0.0f)) continue;
      const float left = clear * expf(-depth);
      const float seen = clear - left;
      clear = left;
      sum.depth += seen * t;
      sum.albedo += albedo_at(scene.transfer, value) * seen;
      if (seen > most) {
        most = seen;
        most_at = t;
      }
    }
  } while (clear > kGuidesEnd && walk.advance());
  if (!(most > 0.0f)) return Guides{};
  sum.opacity = 1.0f - clear;
  sum.normal = gradient_direction(scene, ray.at(most_at)) * sum.opacity;
  return clear > kGuidesEnd ? sum : sum * (1.0f / sum.opacity);
}

}  // namespace diaphane::render
