#pragma once

#include "renderd/film/guides.h"
#include "renderd/kernel/labels.h"
#include "renderd/kernel/medium.h"
#include "renderd/kernel/overlay.h"
#include "renderd/kernel/scatter.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"

namespace diaphane::render {

/// Transmittance below which the ray counts as opaque.
inline constexpr float kGuidesEnd = 0.02f;

/// Returns the guides of the matter visible along `ray` within `span` (inside the grid's box), in
/// steps of at most one voxel. No random numbers are used: a collision found by tracking may be
/// anywhere along the ray, so guides from a few collisions would be as noisy as the picture that
/// they help to denoise. The steps cause a bias, which does no harm, because guides only say which
/// pixels are alike.
template <Features F = Features{}, typename Volume>
HOST_DEVICE Guides guides_along(const SceneView<Volume>& scene, const Ray& ray, Span span,
                                SharesOf<F> shares = {}) {
  Guides sum{};
  if (!(span.begin < span.end)) return sum;
  const Float3 d = ray.direction;
  const float per_step =
      max(max(fabsf(d.x), fabsf(d.y)), fabsf(d.z));  // voxels per mm along the fastest axis
  float clear = 1.0f, most = 0.0f, most_at = span.begin, most_value = 0.0f;
  [[maybe_unused]] bool most_second = false;
  const auto medium = medium_of<F>(scene, shares);
  CellWalk walk(ray, span, scene.grid);
  do {
    if (!(scene.grid.cells[walk.cell()].majorant > 0.0f)) continue;
    const float length = walk.end() - walk.begin();
    const std::int32_t steps =
        1 + static_cast<std::int32_t>(min(length * per_step, 4.0f * kCellSize));
    const float step = length / static_cast<float>(steps);
    for (std::int32_t i = 0; i < steps && clear > kGuidesEnd; ++i) {
      const float t = walk.begin() + (static_cast<float>(i) + 0.5f) * step;
      const Float3 place = ray.at(t);
      const float value = scene.volume.at(place);
      const float depth = medium.extinction(value, place) * step;
      if (!(depth > 0.0f)) continue;
      const float left = clear * expf(-depth);
      const float weight = clear - left;
      clear = left;
      sum.depth += weight * t;
      Float3 albedo = albedo_at(scene.transfer, value);
      if constexpr (F.has(Feature::kLabels)) {
        const LabelLook look = look_at(scene.labels, scene.volume.size, place);
        albedo = albedo_of(scene, place, look, albedo);
      }
      [[maybe_unused]] float of_second = 0.0f;  // its share of the matter
      if constexpr (F.has(Feature::kOverlay)) {
        of_second = medium.second_extinction(place) * step / depth;
        if (of_second > 0.0f) {
          const Float3 other = albedo_at(scene.overlay.transfer, medium.second_value(place));
          albedo = albedo + (other - albedo) * of_second;
        }
      }
      sum.albedo += albedo * weight;
      if (weight > most) {
        most = weight;
        most_at = t;
        most_value = value;
        most_second = of_second > 0.5f;
      }
    }
  } while (clear > kGuidesEnd && walk.advance());
  if (!(most > 0.0f)) return Guides{};
  sum.opacity = 1.0f - clear;
  if constexpr (F.has(Feature::kOverlay)) {
    if (most_second) most_value = medium.second_value(ray.at(most_at));
  }
  sum.normal =
      gradient_at<F>(scene, ray.at(most_at), most_value, most_second).direction * sum.opacity;
  return clear > kGuidesEnd ? sum : sum * (1.0f / sum.opacity);
}

}  // namespace diaphane::render
