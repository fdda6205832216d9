#pragma once

#include "renderd/kernel/medium.h"
#include "renderd/kernel/overlay.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"
#include "renderd/math/random.h"

namespace diaphane::render {

/// Optical depth and ratio at which the transmittance estimate starts Russian roulette. Any values
/// are unbiased; these gave the least variance times time on the cranium scene.
inline constexpr float kRouletteDepth = 1.5f;
inline constexpr float kRouletteRatio = 0.3f;

/// If clear and opaque matter share a macrocell, tracking under one majorant takes a step per unit
/// of optical depth of the *densest* place. With `Steep`, a macrocell of more than this optical
/// depth under its majorant is crossed voxel by voxel, each under a majorant of its own. That takes
/// about one step per voxel for any extinction.
inline constexpr float kDeepCell = 16.0f;

struct Collision {
  float distance;  ///< mm along the ray
  float value;     ///< voxel value there, of the scan that the matter belongs to
  bool found;
  bool hit_medium;  ///< the extinction was not 0 at a tentative collision, so the ray meets matter
  bool second = false;  ///< the matter belongs to the second scan
};

/// Tracks a ray through `piece` by delta tracking under `majorant` > 0. `pending` is the optical
/// depth of the majorant up to the next tentative collision, on entry and on exit without a
/// collision. It is not a distance, because a step of 1e-6 mm would be lost when added to 100 mm.
template <typename AnyMedium>
HOST_DEVICE void track_piece(const Ray& ray, Span piece, float majorant, const AnyMedium& medium,
                             Random& random, float& pending, Collision& hit) {
  const float depth_of_piece = majorant * (piece.end - piece.begin);
  const float inverse = 1.0f / majorant;
  float depth = pending;
  while (depth < depth_of_piece) {
    const float t = piece.begin + depth * inverse;
    const Float3 place = ray.at(t);
    const float value = medium.volume.at(place);
    const float extinction = medium.extinction(value, place);
    const Random::Pair u = random.unit_and_exponential();
    hit.hit_medium |= extinction > 0.0f;
    if (u.a * majorant < extinction) {
      hit.distance = t;
      hit.value = value;
      hit.found = true;
      if constexpr (AnyMedium::kTwoScans) {
        // Given a collision, the product is uniform below the extinction.
        hit.second = !(u.a * majorant < medium.first_extinction(value, place));
        if (hit.second) hit.value = medium.second_value(place);
      }
      return;
    }
    depth += u.b;
  }
  pending = depth - depth_of_piece;
}

/// Finds the first real collision along `ray` within `span` (inside the grid's box), by delta
/// tracking through the macrocells (Woodcock 1965; local majorants: Szirmay-Kalos 2011). The result
/// is unbiased if the bounds of each cell hold.
template <bool Steep = false, typename AnyMedium>
HOST_DEVICE Collision track(const Ray& ray, Span span, const GridView& grid,
                            const AnyMedium& medium, Random& random) {
  Collision hit{0.0f, 0.0f, false, false};
  float pending = random.exponential();
  CellWalk walk(ray, span, grid);
  do {
    const float majorant = grid.cells[walk.cell()].majorant;
    if (!(majorant > 0.0f)) continue;
    const Span piece{walk.begin(), walk.end()};
    if constexpr (Steep) {
      if (majorant * (piece.end - piece.begin) > kDeepCell) {
        VoxelWalk voxels(ray, piece, medium.volume.size);
        do {
          const float local = medium.majorant(voxels.coordinates(), walk.cell());
          if (!(local > 0.0f)) continue;
          track_piece(ray, Span{voxels.begin(), voxels.end()}, local, medium, random, pending, hit);
          if (hit.found) return hit;
        } while (voxels.advance());
        continue;
      }
    }
    track_piece(ray, piece, majorant, medium, random, pending, hit);
    if (hit.found) return hit;
  } while (walk.advance());
  return hit;
}

/// Multiplies `ratio` by an estimate of the transmittance of `piece`, by ratio tracking of the
/// extinction above `bounds.minorant`, or sets it to 0 by roulette. `pending`: see track_piece().
template <typename AnyMedium>
HOST_DEVICE void dim_by_piece(const Ray& ray, Span piece, CellBounds bounds,
                              const AnyMedium& medium, Random& random, float& pending,
                              float& ratio) {
  const float residual = bounds.majorant - bounds.minorant;
  const float depth_of_piece = residual * (piece.end - piece.begin);
  float depth = pending;
  if (depth < depth_of_piece) {
    const float inverse = 1.0f / residual;
    do {
      const float t = piece.begin + depth * inverse;
      const Float3 place = ray.at(t);
      const float extinction = medium.extinction(medium.volume.at(place), place);
      const Random::Pair u = random.unit_and_exponential();
      ratio *= max((bounds.majorant - extinction) * inverse, 0.0f);
      if (ratio < kRouletteRatio) {
        if (u.a * kRouletteRatio >= ratio) {
          ratio = 0.0f;
          return;
        }
        ratio = kRouletteRatio;
      }
      depth += u.b;
    } while (depth < depth_of_piece);
  }
  pending = depth - depth_of_piece;
}

/// Returns an unbiased estimate of the transmittance along `ray` over `span`, by residual ratio
/// tracking (Novak et al. 2014). The minorant of each cell is applied exactly and the rest by ratio
/// tracking. Nearly dark rays end by roulette.
template <bool Steep = false, typename AnyMedium>
HOST_DEVICE float transmittance(const Ray& ray, Span span, const GridView& grid,
                                const AnyMedium& medium, Random& random) {
  float ratio = 1.0f;
  float control = 0.0f;  // optical depth of the minorants not yet accounted for
  float pending = random.exponential();
  CellWalk walk(ray, span, grid);
  do {
    const CellBounds bounds = grid.cells[walk.cell()];
    if (!(bounds.majorant > 0.0f)) continue;
    const Span piece{walk.begin(), walk.end()};
    const float length = piece.end - piece.begin;
    control += bounds.minorant * length;
    // The ray survives the exact part with probability exp(-control), so that it ends by chance
    // where little light is left.
    if (control > kRouletteDepth) {
      if (random.exponential() < control) return 0.0f;
      control = 0.0f;
    }
    if constexpr (Steep) {
      if ((bounds.majorant - bounds.minorant) * length > kDeepCell) {
        VoxelWalk voxels(ray, piece, medium.volume.size);
        do {
          const float local = medium.majorant(voxels.coordinates(), walk.cell());
          if (!(local > bounds.minorant)) continue;
          dim_by_piece(ray, Span{voxels.begin(), voxels.end()}, CellBounds{bounds.minorant, local},
                       medium, random, pending, ratio);
          if (ratio == 0.0f) return 0.0f;
        } while (voxels.advance());
        continue;
      }
    }
    dim_by_piece(ray, piece, bounds, medium, random, pending, ratio);
    if (ratio == 0.0f) return 0.0f;
  } while (walk.advance());
  return ratio * expf(-control);
}

}  // namespace diaphane::render
