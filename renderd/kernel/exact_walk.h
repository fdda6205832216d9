#pragma once

#include "renderd/kernel/exact_cell.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"

namespace diaphane::render {

/// A cell that a ray crosses.
template <typename Volume>
struct CellCrossing {
  Crossing segment;
  Int3 cell;
  typename Volume::Brick brick;
  Float3 planes;  ///< distance at which the ray leaves the cell along each axis, mm
};

/// Walks the cells between voxel centres along a ray in order and skips empty bricks. Cell (i, j,
/// k) has the voxels i - 1 and i along x as corners (clamped at the edges), where i ranges from 0
/// to the number of voxels, and likewise along y and z.
///
/// Cells are counted in integers. A distance is computed from an integer plane instead of the
/// previous distance, and never decreases. Therefore all rays end, even rays that start inside, run
/// along axes or pass through edges and corners. A direction component of zero is replaced by
/// 1e-20, which reaches no plane.
template <typename Volume>
class ExactWalk {
 public:
  ExactWalk() = default;  ///< uninitialised; assign before use
  HOST_DEVICE ExactWalk(const Ray& ray, Span span, const Volume& volume, const ExactView& exact)
      : origin_(ray.origin + Float3{0.5f, 0.5f, 0.5f}),
        direction_{away_from_zero(ray.direction.x), away_from_zero(ray.direction.y),
                   away_from_zero(ray.direction.z)},
        inverse_{quotient_near(1.0f, direction_.x), quotient_near(1.0f, direction_.y),
                 quotient_near(1.0f, direction_.z)},
        t_(span.begin),
        last_(span.end),
        octant_(((direction_.x > 0.0f ? 1 : 0) | (direction_.y > 0.0f ? 2 : 0) |
                 (direction_.z > 0.0f ? 4 : 0)) *
                exact.brick_count) {
    bias_ = (Float3{ahead(direction_.x), ahead(direction_.y), ahead(direction_.z)} - origin_) *
            inverse_;
    const Float3 p = origin_ + direction_ * t_;
    cell_ = {cell_at(p.x, exact.size.x), cell_at(p.y, exact.size.y), cell_at(p.z, exact.size.z)};
    enter(volume, exact);
  }

  HOST_DEVICE bool ended() const { return !(t_ < last_); }
  /// Returns whether the ray is at a cube of empty bricks and not at a cell. Requires that the walk
  /// has not ended.
  HOST_DEVICE bool in_gap() const { return skip_ != 0; }

  /// Computes the segment in the current cell or cube.
  HOST_DEVICE void compute_crossing(CellCrossing<Volume>& out) const {
    const Int3 far = far_cell();
    // With a fused multiply-add, each component is rounded only once.
    out.planes = as_numbers(far) * inverse_ + bias_;
    const float leaves = fast_min(out.planes.x, fast_min(out.planes.y, out.planes.z));
    out.segment = {origin_ - as_numbers(cell_), direction_, t_,
                   fast_min(last_, fast_max(t_, leaves))};
    out.cell = cell_;
    out.brick = brick_;
  }
  /// Moves to the next cell or cube after the one from compute_crossing(). It has no branches,
  /// because the rays of a warp leave through different sides.
  HOST_DEVICE void pass(const CellCrossing<Volume>& at, const Volume& volume,
                        const ExactView& exact) {
    // The segment ends at last_ at the latest, so no cell beyond last_ is visited.
    t_ = at.segment.t1;
    const Int3 far = far_cell();
    const Float3 p = origin_ + direction_ * t_;
    const Float3 plane = at.planes;
    const bool x = plane.x <= plane.y && plane.x <= plane.z, y = !x && plane.y <= plane.z;
    const Int3 next{x ? far.x + sign(direction_.x) : beside(direction_.x, cell_.x, p.x),
                    y ? far.y + sign(direction_.y) : beside(direction_.y, cell_.y, p.y),
                    x || y ? beside(direction_.z, cell_.z, p.z) : far.z + sign(direction_.z)};
    const std::int32_t changed = (next.x ^ cell_.x) | (next.y ^ cell_.y) | (next.z ^ cell_.z);
    cell_ = next;
    if (changed >> kBrickShift != 0) enter(volume, exact);
  }

 private:
  HOST_DEVICE static float away_from_zero(float d) {
    return fabsf(d) < 1e-20f ? (d < 0.0f ? -1e-20f : 1e-20f) : d;
  }
  HOST_DEVICE static float ahead(float direction) { return direction > 0.0f ? 1.0f : 0.0f; }
  HOST_DEVICE static std::int32_t sign(float direction) { return direction > 0.0f ? 1 : -1; }
  /// Returns the cell that contains `p`. The comparison maps positions below the grid and NaN to 0.
  HOST_DEVICE static std::int32_t cell_at(float p, std::int32_t size) {
    return p > 0.0f ? static_cast<std::int32_t>(min(p, static_cast<float>(size))) : 0;
  }
  HOST_DEVICE static Float3 as_numbers(Int3 i) {
    return {static_cast<float>(i.x), static_cast<float>(i.y), static_cast<float>(i.z)};
  }
  /// Returns the last cell along each axis that the ray can meet before it leaves the current cell
  /// or cube.
  HOST_DEVICE Int3 far_cell() const {
    const bool gap = in_gap();
    const std::int32_t rest = gap ? kBrickSize - 1 : 0, bricks = gap ? (skip_ - 1) * kBrickSize : 0;
    const auto along = [rest, bricks](std::int32_t cell, float direction) {
      return direction > 0.0f ? (cell | rest) + bricks : (cell & ~rest) - bricks;
    };
    return {along(cell_.x, direction_.x), along(cell_.y, direction_.y),
            along(cell_.z, direction_.z)};
  }
  /// Returns the next cell along an axis along which the ray did not leave. In a cube, the rounded
  /// position may lie in a cell that the ray has passed. The walk must never go back, or rays
  /// through corners would not end.
  HOST_DEVICE std::int32_t beside(float direction, std::int32_t cell, float p) const {
    const auto there = static_cast<std::int32_t>(floorf(p));
    const std::int32_t on = direction > 0.0f ? max(cell, there) : min(cell, there);
    return in_gap() ? on : cell;
  }

  /// Looks up the brick of cell_, which may be one brick beyond the volume.
  HOST_DEVICE void enter(const Volume& volume, const ExactView& exact) {
    skip_ = 0;
    if (ended()) return;
    const std::int32_t brick = (cell_.x >> kBrickShift) +
                               (cell_.y >> kBrickShift) * exact.brick_row +
                               (cell_.z >> kBrickShift) * exact.brick_slice;
    skip_ = exact.skips[octant_ + brick];
    brick_ = volume.brick(brick);
    if (skip_ == kOutside) t_ = last_;
  }

  Float3 origin_, direction_, inverse_;  ///< in cells
  Float3 bias_;  ///< distances at which the ray leaves the cell at index 0, mm
  float t_, last_;
  Int3 cell_;
  std::int32_t octant_;  ///< offset of the ray's octant in ExactView::skips
  std::int32_t skip_;    ///< entry of the brick in ExactView::skips
  typename Volume::Brick brick_;
};

}  // namespace diaphane::render
