#pragma once

#include <type_traits>

#include "renderd/kernel/camera.h"
#include "renderd/kernel/direct.h"
#include "renderd/kernel/estimator.h"
#include "renderd/kernel/exact_cell.h"
#include "renderd/kernel/exact_walk.h"
#include "renderd/kernel/medium.h"
#include "renderd/kernel/views.h"
#include "renderd/math/points.h"
#include "renderd/math/random.h"

// The exact walk: single scattering without tracking. It walks a camera ray once, through every
// cell between voxel centres, and computes the optical depth exactly. Unlike tracking, it can
// therefore place several collisions, one in each stratum of the ray's opacity. Each collision
// samples light along one ray, whose transmittance is exact as well. Only the place in the pixel,
// the offset of the strata and the points on the lights remain random.

namespace diaphane::render {

/// Beyond this optical depth, Russian roulette ends a ray with the probability that light collides
/// there. On the cranium scene, 2 instead of 5 raises the error by 3% and lowers the time by 18%
/// (docs/performance.md).
#if !defined(DIAPHANE_CERTAIN_DEPTH)
#define DIAPHANE_CERTAIN_DEPTH 2.0f
#endif
inline constexpr float kCertainDepth = DIAPHANE_CERTAIN_DEPTH;

/// Computes the optical depth along a ray in steps.
template <Features F, typename Volume>
class DepthWalk {
 public:
  DepthWalk() = default;  ///< uninitialised; assign before use
  HOST_DEVICE DepthWalk(const Ray& ray, Span span, const Volume& volume, const ExactView& exact)
      : walk_(ray, span, volume, exact) {}

  HOST_DEVICE bool ended() const { return walk_.ended(); }
  /// Returns the exact optical depth up to the current position.
  HOST_DEVICE float depth() const { return depth_; }

  /// Takes one step of a walk that has not ended. Returns true if it finished the cell `c`.
  HOST_DEVICE bool step(const Volume& volume, const ExactView& exact, CellCrossing<Volume>& c) {
    if (!in_parts()) return step_cell(volume, exact, c);
    if (at_new_parts()) begin_parts(volume, exact);
    return step_part(volume, exact, c);
  }

  // The functions below split step(), so that a GPU can group rays in the same state. in_parts()
  // returns whether the walk is in a cell whose values span several pieces of the extinction
  // function. Such cells are expensive.
  HOST_DEVICE bool in_parts() const {
    if constexpr (kCurved) return parts_.state != Parts::kNone;
    return false;
  }
  HOST_DEVICE bool at_new_parts() const {
    if constexpr (kCurved) return parts_.state == Parts::kNew;
    return false;
  }
  /// Crosses a cell or empty bricks, or stops at a cell of several pieces. Returns true for a cell.
  HOST_DEVICE bool step_cell(const Volume& volume, const ExactView& exact,
                             CellCrossing<Volume>& c) {
    walk_.compute_crossing(c);
    const bool gap = walk_.in_gap();
    if (!gap) {
      ExtinctionPiece piece = exact.only;
      if constexpr (kCurved) {
        if (!one_piece(exact, volume.corner_values(c.cell, c.brick), piece)) {
          parts_.state = Parts::kNew;
          return false;
        }
      }
      depth_ += depth_in(piece, volume.corners(c.cell, c.brick), c.segment);
    }
    walk_.pass(c, volume, exact);
    return !gap;
  }
  /// Begins to walk the pieces of the cell at which step_cell() stopped.
  HOST_DEVICE void begin_parts(const Volume& volume, const ExactView& exact) {
    if constexpr (kCurved) {
      CellCrossing<Volume> c;
      walk_.compute_crossing(c);
      parts_.walk = PartsWalk(volume.corners(c.cell, c.brick), c.segment, exact);
      parts_.state = Parts::kUnderWay;
    }
  }
  HOST_DEVICE bool step_part(const Volume& volume, const ExactView& exact,
                             CellCrossing<Volume>& c) {
    if constexpr (kCurved) {
      walk_.compute_crossing(c);
      const PartsWalk::Part part = parts_.walk.next(exact);
      depth_ += parts_.walk.depth_of(part, c.segment.t1 - c.segment.t0);
      if (!parts_.walk.ended()) return false;
      parts_.state = Parts::kNone;
      walk_.pass(c, volume, exact);
    }
    return true;
  }

 private:
  static constexpr bool kCurved = F.has(Feature::kCurves);
  struct Parts {
    enum State : int { kNone, kNew, kUnderWay } state = kNone;
    PartsWalk walk;
  };
  struct NoParts {};

  ExactWalk<Volume> walk_;
  float depth_ = 0.0f;
  [[no_unique_address]] std::conditional_t<kCurved, Parts, NoParts> parts_;
};

/// Estimates the transmittance along a ray, without bias and exactly up to kCertainDepth.
template <Features F, typename Volume>
class TransmittanceWalk : public DepthWalk<F, Volume> {
 public:
  TransmittanceWalk() = default;  ///< uninitialised; assign before use
  /// `ending` is an exponential variate, which decides where roulette ends the ray.
  HOST_DEVICE TransmittanceWalk(const Ray& ray, Span span, const Volume& volume,
                                const ExactView& exact, float ending)
      : DepthWalk<F, Volume>(ray, span, volume, exact), dark_(kCertainDepth + ending) {}

  /// Returns true earlier than the walk itself if no light is left.
  HOST_DEVICE bool ended() const { return DepthWalk<F, Volume>::ended() || this->depth() >= dark_; }
  /// Returns the estimate. Requires that the walk has ended.
  HOST_DEVICE float transmittance() const {
    return this->depth() >= dark_ ? 0.0f : expf(-min(this->depth(), kCertainDepth));
  }

 private:
  float dark_;
};

/// Maximum number of hits of a camera ray, of all strategies together.
inline constexpr int kMostHits = 32;

/// A collision of a camera ray.
struct Hit {
  float distance;  ///< mm
  float value;
};

/// The fraction by which the first strata of a ray's opacity are narrower than their mean, and the
/// last ones wider. Places behind other matter get less light, so errors there are smaller. The
/// value was measured on the cranium scene (docs/performance.md).
#if !defined(DIAPHANE_STRATA_TILT)
#define DIAPHANE_STRATA_TILT 0.4f
#endif
inline constexpr float kStrataTilt = DIAPHANE_STRATA_TILT;

/// A stratum of a ray's opacity, from `begin` to `begin + width`.
struct OpacityStratum {
  float begin, width;

  /// Makes stratum `number` of `count`.
  HOST_DEVICE OpacityStratum(std::int32_t number, std::int32_t count) {
    const float one = 1.0f / static_cast<float>(count), x = static_cast<float>(number) * one;
    begin = x * (1.0f - kStrataTilt + kStrataTilt * x);
    width = one * (1.0f - kStrataTilt + kStrataTilt * (2.0f * x + one));
  }
};

/// Returns the optical depth at which the collision of a kind in stratum `number` of `count` is
/// placed. All strata share `offset` in (0, 1), but every second stratum counts it from its end.
/// Light falls off with depth, so the errors of neighbouring strata partly cancel.
HOST_DEVICE float target_depth(std::int32_t number, std::int32_t count, float offset) {
  const OpacityStratum stratum(number, count);
  const float share = (number & 1) != 0 ? 1.0f - offset : offset;
  // -log(1 - u)
  return -log1pf(-min(stratum.begin + share * stratum.width, 0x1.fffffep-1f));
}
inline constexpr float kNoTarget = 3.4e38f;

/// Results of the walk of a camera ray other than its collisions.
struct FirstWalk {
  float transmittance;  ///< of the whole span, unbiased
  bool hit_medium;
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
  // Glowing matter is visible without any light, so some kind must look for collisions.
  if (list.count == 0) list.of[list.count++] = static_cast<int>(Strategy::kEnvironment);
  if (F.has(Feature::kBounces)) list.of[list.count++] = kIndirect;
  return list;
}

/// Returns whether a ray in the state `one` continues now. On a GPU, the rays of a warp can be in
/// two states, and the smaller group waits.
HOST_DEVICE bool has_turn([[maybe_unused]] bool one) {
#if defined(__CUDA_ARCH__)
  const unsigned here = __activemask();
  return one == (2 * __popc(__ballot_sync(here, one)) > __popc(here));
#else
  return true;
#endif
}

/// Identifies a collision of a camera ray.
struct HitNumber {
  int kind;
  std::int32_t stratum;  ///< number of the stratum within its kind
  std::int32_t of_all;   ///< number across all kinds
};

/// Finds the collisions of the camera ray in each stratum. Calls `mark(number, cell, depth)` for
/// each existing one in order, with the crossing that contains it and the optical depth from the
/// entry to the collision (place_in_cell() finds its position). `target(number)` is target_depth().
/// `ending` is an exponential variate.
template <Features F, typename Volume, typename Target, typename Mark>
HOST_DEVICE FirstWalk find_hits(const Ray& ray, Span span, const Volume& volume,
                                const ExactView& exact, Target&& target, float ending,
                                bool needs_transmittance, Mark&& mark) {
  constexpr KindList kKinds = hit_kinds<F>();
  std::int32_t first[kKinds.count], stratum[kKinds.count];
  float next[kKinds.count];
  float nearest = kNoTarget, furthest = 0.0f;
  for (int k = 0; k < kKinds.count; ++k) {
    const int kind = kKinds.of[k];
    const std::int32_t count = exact.strata[kind];
    first[k] = 0;
    for (int other = 0; other < kind; ++other) first[k] += exact.strata[other];
    stratum[k] = 0;
    next[k] = count > 0 ? target(HitNumber{kind, 0, first[k]}) : kNoTarget;
    nearest = min(nearest, next[k]);
    if (count > 0) {
      furthest = max(furthest, target(HitNumber{kind, count - 1, first[k] + count - 1}));
    }
  }
  const float dark = furthest + (needs_transmittance ? ending : 0.0f);
  DepthWalk<F, Volume> walk(ray, span, volume, exact);
  CellCrossing<Volume> c;
  float before = 0.0f;
  while (!walk.ended()) {
    if (F.has(Feature::kCurves) && !has_turn(walk.in_parts())) continue;
    if (!walk.step(volume, exact, c)) continue;
    while (nearest < walk.depth()) {
      // All kinds share this code, because on a GPU few rays of a warp are here at a time. It
      // selects by conditions instead of an index, because indexed variables would be stored in
      // memory.
      HitNumber here{};
      std::int32_t count = 0;
      bool found = false, mine[kKinds.count];
      for (int k = 0; k < kKinds.count; ++k) {
        mine[k] = !found && next[k] == nearest;
        found = found || mine[k];
        here.kind = mine[k] ? kKinds.of[k] : here.kind;
        here.stratum = mine[k] ? stratum[k] : here.stratum;
        here.of_all = mine[k] ? first[k] + stratum[k] : here.of_all;
        count = mine[k] ? exact.strata[kKinds.of[k]] : count;
      }
      mark(here, c, nearest - before);
      ++here.stratum;
      ++here.of_all;
      const float after = here.stratum < count ? target(here) : kNoTarget;
      nearest = kNoTarget;
      for (int k = 0; k < kKinds.count; ++k) {
        stratum[k] = mine[k] ? here.stratum : stratum[k];
        next[k] = mine[k] ? after : next[k];
        nearest = min(nearest, next[k]);
      }
    }
    before = walk.depth();
    if (before >= dark) break;
  }
  const float depth = walk.depth();
  return {depth >= dark ? 0.0f : expf(-min(depth, furthest)), depth > 0.0f};
}

}  // namespace diaphane::render
