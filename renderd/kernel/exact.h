#pragma once

#include "renderd/kernel/camera.h"
#include "renderd/kernel/direct.h"
#include "renderd/kernel/estimator.h"
#include "renderd/kernel/exact_cell.h"
#include "renderd/kernel/exact_walk.h"
#include "renderd/kernel/medium.h"
#include "renderd/kernel/views.h"
#include "renderd/math/points.h"
#include "renderd/math/random.h"

// The exact walk: single scattering without tracking. A camera ray is walked once, through every
// cell between voxel centres, with the optical depth known exactly; that gives several collisions,
// one in each stratum of the ray's opacity, which no tracker can do. Each looks for light along one
// ray whose transmittance is exact as well. What is left to chance are the place in the pixel, the
// strata's offset, and the points on the lights.

namespace diaphane::render {

/// Beyond this optical depth a ray goes on by chance: it ends with the probability that light
/// would.
#if !defined(DIAPHANE_CERTAIN_DEPTH)
#define DIAPHANE_CERTAIN_DEPTH 5.0f
#endif
inline constexpr float kCertainDepth = DIAPHANE_CERTAIN_DEPTH;

/// The transmittance along a ray, found in steps, so that a GPU may put another ray in its place
/// when it ends. Unbiased; exact but for what is beyond kCertainDepth.
template <Features F, typename Volume>
class TransmittanceWalk {
 public:
  TransmittanceWalk() = default;  ///< to be assigned to
  /// `ending` is an exponential variate.
  HOST_DEVICE TransmittanceWalk(const Ray& ray, Span span, const Volume& volume,
                                const ExactView& exact, float ending)
      : walk_(ray, span, volume, exact), dark_(kCertainDepth + ending) {}

  HOST_DEVICE bool ended() const { return walk_.ended() || depth_ >= dark_; }
  /// One step, across a cell or over empty ones, until it has ended.
  HOST_DEVICE void step(const Volume& volume, const ExactView& exact) {
    if (in_gap()) {
      jump(volume, exact);
    } else if (!cross(volume, exact)) {
      cross_parts(volume, exact);
    }
  }

  // The same in three, so that a GPU can gather rays that wait for the same.
  HOST_DEVICE bool in_gap() const { return walk_.in_gap(); }
  HOST_DEVICE void jump(const Volume& volume, const ExactView& exact) { walk_.jump(volume, exact); }
  /// Across a cell; false, and nothing done, when its values lie in several pieces of the function:
  /// cross_parts() does it, and costs much.
  HOST_DEVICE bool cross(const Volume& volume, const ExactView& exact) {
    CellCrossing<Volume> c;
    walk_.look(c);
    ExtinctionPiece piece = exact.only;
    if constexpr (F.has(Feature::kCurves)) {
      if (!one_piece(exact, volume.corner_values(c.cell, c.brick), piece)) return false;
    }
    const Corners corners = volume.corners(c.cell, c.brick);
    walk_.pass(c, volume, exact);
    depth_ += depth_in(piece, corners, c.way);
    return true;
  }
  HOST_DEVICE void cross_parts(const Volume& volume, const ExactView& exact) {
    CellCrossing<Volume> c;
    walk_.look(c);
    const Corners corners = volume.corners(c.cell, c.brick);
    walk_.pass(c, volume, exact);
    depth_ += depth_of_parts(corners, c.way, exact);
  }
  /// Once it has ended.
  HOST_DEVICE float transmittance() const {
    return depth_ >= dark_ ? 0.0f : expf(-smaller(depth_, kCertainDepth));
  }

 private:
  ExactWalk<Volume> walk_;
  float depth_ = 0.0f, dark_;
};

/// Of all strategies of a camera ray.
inline constexpr int kMostHits = 32;

/// A collision of a camera ray.
struct Hit {
  float distance;  ///< mm; negative: none in this stratum
  float value;
};

/// Targets of one strategy: optical depths, one in each of `count` equal strata of the opacity, all
/// moved by the same offset in (0, 1).
struct Strata {
  float offset = 0.0f, step = 0.0f;
  std::int32_t next = 0, count = 0;

  HOST_DEVICE float target(std::int32_t stratum) const {
    if (stratum >= count) return 3.4e38f;
    // -log(1 - u)
    return -log1pf(-smaller((static_cast<float>(stratum) + offset) * step, 0x1.fffffep-1f));
  }
};

/// What the walk of a camera ray finds besides its collisions.
struct FirstWalk {
  float transmittance;  ///< unbiased, of the whole span
  bool met_matter;
};

/// The kinds of hit (ExactView::strata) that a kernel with these features looks for.
struct KindList {
  int of[kHitKinds];
  int count;
};
template <Features F>
HOST_DEVICE constexpr KindList hit_kinds() {
  KindList list{};
  constexpr StrategyList kLight = strategies<F>();
  for (std::uint32_t i = 0; i < kLight.count; ++i)
    list.of[list.count++] = static_cast<int>(kLight.of[i]);
  // Matter that glows is seen without any light.
  if (list.count == 0) list.of[list.count++] = static_cast<int>(Strategy::kEnvironment);
  if (F.has(Feature::kBounces)) list.of[list.count++] = kOnwards;
  return list;
}

/// Collisions of the camera ray in each stratum: `mark(kind, stratum, corners, crossing, depth)` is
/// called for those that there are, in order, with the cell that holds it and the optical depth
/// from the cell's entry to it (place_in_cell finds where that is). `offset(kind)` in (0, 1) moves
/// a kind's strata. `ending` is an exponential variate.
template <Features F, typename Volume, typename Offset, typename Mark>
HOST_DEVICE FirstWalk find_hits(const Ray& ray, Span span, const Volume& volume,
                                const ExactView& exact, Offset&& offset, float ending,
                                bool needs_transmittance, Mark&& mark) {
  constexpr KindList kKinds = hit_kinds<F>();
  Strata strata[kKinds.count];
  float target[kKinds.count];
  float nearest = 3.4e38f, furthest = 0.0f;
  for (int k = 0; k < kKinds.count; ++k) {
    const std::int32_t count = exact.strata[kKinds.of[k]];
    strata[k] = {offset(kKinds.of[k]), count > 0 ? 1.0f / static_cast<float>(count) : 0.0f, 0,
                 count};
    target[k] = strata[k].target(0);
    nearest = smaller(nearest, target[k]);
    if (count > 0) furthest = larger(furthest, strata[k].target(count - 1));
  }
  const float dark = furthest + (needs_transmittance ? ending : 0.0f);
  ExactWalk<Volume> walk(ray, span, volume, exact);
  CellCrossing<Volume> c;
  float depth = 0.0f;
  while (!walk.ended()) {
    if (walk.in_gap()) {
      walk.jump(volume, exact);
      continue;
    }
    walk.look(c);
    constexpr bool kCurved = F.has(Feature::kCurves);
    const Corners corners = volume.corners(c.cell, c.brick);
    CornerRange range{0, 0};
    if constexpr (kCurved) range = volume.corner_values(c.cell, c.brick);
    walk.pass(c, volume, exact);
    const float after = depth + depth_of_cell<kCurved>(corners, range, c.way, exact);
    while (nearest < after) {
      float following = 3.4e38f;
      for (int k = 0; k < kKinds.count; ++k) {
        if (target[k] <= nearest) {
          mark(kKinds.of[k], strata[k].next, corners, c.way, nearest - depth);
          ++strata[k].next;
          target[k] = strata[k].target(strata[k].next);
        }
        following = smaller(following, target[k]);
      }
      nearest = following;
    }
    depth = after;
    if (depth >= dark) break;
  }
  return {depth >= dark ? 0.0f : expf(-smaller(depth, furthest)), depth > 0.0f};
}

}  // namespace diaphane::render
