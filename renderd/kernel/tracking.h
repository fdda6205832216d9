#pragma once

#include "renderd/kernel/medium.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"
#include "renderd/math/random.h"

namespace diaphane::render {

/// Extinction by place: the transfer function after the interpolation of voxels.
template <typename Volume>
struct Medium {
  const Volume& volume;
  const TransferView& transfer;

  HOST_DEVICE float value(Float3 index) const { return volume.at(index); }
  HOST_DEVICE float extinction(float value) const { return extinction_at(transfer, value); }
};

/// Where the transmittance estimate starts to play roulette: an optical depth, a ratio. Any value
/// is unbiased; these were measured to give the least variance times time on the cranium scene.
inline constexpr float kRouletteDepth = 1.5f;
inline constexpr float kRouletteRatio = 0.3f;

struct Collision {
  float distance;  ///< mm along the ray
  float value;     ///< voxel value there
  bool found;
  bool met_matter;  ///< some tentative collision had extinction: the ray meets contents
};

/// The first real collision along `ray` within `span` (inside the grid's box), by delta tracking
/// through the macrocells (Woodcock 1965; local majorants: Szirmay-Kalos 2011). Unbiased while the
/// bounds of each cell hold.
template <typename Volume>
HOST_DEVICE Collision track(const Ray& ray, Span span, const GridView& grid,
                            const Medium<Volume>& medium, Random& random) {
  Collision hit{0.0f, 0.0f, false, false};
  float pending =
      random.exponential();  // optical depth of the majorant to the next tentative collision
  CellWalk walk(ray, span, grid);
  do {
    const float majorant = grid.cells[walk.cell()].majorant;
    if (majorant > 0.0f) {
      // Optical depth from the cell's border on, not a distance: a step of 1e-6 mm is not lost
      // beside 100 mm.
      const float cell_depth = majorant * (walk.end() - walk.begin());
      const float inverse = 1.0f / majorant;
      float depth = pending;
      while (depth < cell_depth) {
        const float t = walk.begin() + depth * inverse;
        const float value = medium.value(ray.at(t));
        const float extinction = medium.extinction(value);
        const Random::Pair u = random.unit_and_exponential();
        hit.met_matter |= extinction > 0.0f;
        if (u.a * majorant < extinction) {
          hit.distance = t;
          hit.value = value;
          hit.found = true;
          return hit;
        }
        depth += u.b;
      }
      pending = depth - cell_depth;
    }
  } while (walk.advance());
  return hit;
}

/// An unbiased estimate of the transmittance along `ray` over `span`, by residual ratio tracking
/// (Novak et al. 2014): the minorant of each cell is taken exactly, the rest by ratio tracking;
/// what is nearly dark ends by roulette.
template <typename Volume>
HOST_DEVICE float transmittance(const Ray& ray, Span span, const GridView& grid,
                                const Medium<Volume>& medium, Random& random) {
  float ratio = 1.0f;
  float control = 0.0f;  // optical depth of the minorants not yet accounted for
  float pending = random.exponential();
  CellWalk walk(ray, span, grid);
  do {
    const CellBounds bounds = grid.cells[walk.cell()];
    if (bounds.majorant > 0.0f) {
      const float length = walk.end() - walk.begin();
      control += bounds.minorant * length;
      // Survives the exact part with probability exp(-control): an analog end where little is left
      // anyway.
      if (control > kRouletteDepth) {
        if (random.exponential() < control) return 0.0f;
        control = 0.0f;
      }
      const float residual = bounds.majorant - bounds.minorant;
      const float cell_depth = residual * length;
      float depth = pending;
      if (depth < cell_depth) {
        const float inverse = 1.0f / residual;
        do {
          const float t = walk.begin() + depth * inverse;
          const float extinction = medium.extinction(medium.value(ray.at(t)));
          const Random::Pair u = random.unit_and_exponential();
          ratio *= larger((bounds.majorant - extinction) * inverse, 0.0f);
          if (ratio < kRouletteRatio) {
            if (u.a * kRouletteRatio >= ratio) return 0.0f;
            ratio = kRouletteRatio;
          }
          depth += u.b;
        } while (depth < cell_depth);
      }
      pending = depth - cell_depth;
    }
  } while (walk.advance());
  return ratio * expf(-control);
}

}  // namespace diaphane::render
