#pragma once

#include "renderd/kernel/exact_cell.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"

namespace diaphane::render {

/// A cell of a ray's way.
template <typename Volume>
struct CellCrossing {
  Crossing way;
  Int3 cell;
  typename Volume::Brick brick;
  Float3 planes;  ///< where the ray leaves it along each axis, mm
};

/// The cells between voxel centres along a ray, in order, without those of bricks where nothing is.
/// Cell (i, j, k) has the voxels i - 1 and i along x as corners (clamped at the edges), i from 0 to
/// the number of voxels, and so on.
///
/// Cells are counted in integers, a distance comes from an integer plane and not from the one
/// before, and never goes back: rays along axes, through edges and corners, from inside and of zero
/// components all end. A component of zero is made 1e-20: it reaches no plane.
template <typename Volume>
class ExactWalk {
 public:
  ExactWalk() = default;  ///< to be assigned to
  HOST_DEVICE ExactWalk(const Ray& ray, Span span, const ExactView& exact)
      : origin_(ray.origin + Float3{0.5f, 0.5f, 0.5f}),
        direction_{away_from_zero(ray.direction.x), away_from_zero(ray.direction.y),
                   away_from_zero(ray.direction.z)},
        inverse_{1.0f / direction_.x, 1.0f / direction_.y, 1.0f / direction_.z},
        t_(span.begin),
        last_(span.end),
        octant_(((direction_.x > 0.0f ? 1 : 0) | (direction_.y > 0.0f ? 2 : 0) |
                 (direction_.z > 0.0f ? 4 : 0)) *
                exact.brick_count) {
    bias_ = (Float3{ahead(direction_.x), ahead(direction_.y), ahead(direction_.z)} - origin_) *
            inverse_;
    const Float3 p = origin_ + direction_ * t_;
    cell_ = {cell_at(p.x, exact.size.x), cell_at(p.y, exact.size.y), cell_at(p.z, exact.size.z)};
  }

  HOST_DEVICE bool ended() const { return !(t_ < last_); }

  /// Where the ray is, until it has ended: true when it is at a cell where something may be, and
  /// pass() goes on from there. False when it went over empty bricks or left the volume.
  HOST_DEVICE bool look(const Volume& volume, const ExactView& exact, CellCrossing<Volume>& out) {
    if (new_brick_) {
      const Int3 b{cell_.x >> kBrickShift, cell_.y >> kBrickShift, cell_.z >> kBrickShift};
      if (!within(b, exact.bricks)) {
        t_ = last_;
        return false;
      }
      const std::int32_t index = b.x + exact.bricks.x * (b.y + exact.bricks.y * b.z);
      const std::int32_t skip = exact.skips[octant_ + index];
      brick_ = volume.brick(b, index);
      if (skip != 0) {
        jump(b, skip, exact);
        return false;
      }
      new_brick_ = false;
    }
    const Float3 corner = as_numbers(cell_);
    // One rounding each where the processor has a fused multiply-add.
    out.planes = corner * inverse_ + bias_;
    const float leaves = lower_of(out.planes.x, lower_of(out.planes.y, out.planes.z));
    out.way = {origin_ - corner, direction_, t_, lower_of(last_, higher_of(t_, leaves))};
    out.cell = cell_;
    out.brick = brick_;
    return true;
  }
  /// On to the neighbour of the cell that look() found.
  HOST_DEVICE void pass(const CellCrossing<Volume>& at) {
    // Beyond last_ nothing more is looked at.
    t_ = at.way.t1;
    const Float3 plane = at.planes;
    const bool x = plane.x <= plane.y && plane.x <= plane.z;
    const bool y = !x && plane.y <= plane.z;
    // No branches: the rays of a warp leave through different sides.
    const Int3 next{cell_.x + (x ? sign(direction_.x) : 0), cell_.y + (y ? sign(direction_.y) : 0),
                    cell_.z + (x || y ? 0 : sign(direction_.z))};
    new_brick_ =
        (((next.x ^ cell_.x) | (next.y ^ cell_.y) | (next.z ^ cell_.z)) >> kBrickShift) != 0;
    cell_ = next;
  }

  /// The next cell where something may be; false when the ray has left.
  HOST_DEVICE bool next(const Volume& volume, const ExactView& exact, CellCrossing<Volume>& out) {
    while (!ended()) {
      if (look(volume, exact, out)) {
        pass(out);
        return true;
      }
    }
    return false;
  }

 private:
  HOST_DEVICE static float away_from_zero(float d) {
    return fabsf(d) < 1e-20f ? (d < 0.0f ? -1e-20f : 1e-20f) : d;
  }
  HOST_DEVICE static std::int32_t up(float direction) { return direction > 0.0f ? 1 : 0; }
  HOST_DEVICE static float ahead(float direction) { return direction > 0.0f ? 1.0f : 0.0f; }
  HOST_DEVICE static std::int32_t sign(float direction) { return direction > 0.0f ? 1 : -1; }
  /// The comparison sends what is below the grid, and NaN, to 0.
  HOST_DEVICE static std::int32_t cell_at(float p, std::int32_t size) {
    return p > 0.0f ? static_cast<std::int32_t>(smaller(p, static_cast<float>(size))) : 0;
  }
  /// A cell outside the volume is in another brick than those inside, or in the rest of the last
  /// one, of which a ray within its span meets no more than rounding.
  HOST_DEVICE static bool within(Int3 b, Int3 bricks) {
    const auto in = [](std::int32_t i, std::int32_t n) {
      return static_cast<std::uint32_t>(i) < static_cast<std::uint32_t>(n);
    };
    return in(b.x, bricks.x) && in(b.y, bricks.y) && in(b.z, bricks.z);
  }
  HOST_DEVICE float plane_distance(int axis, float plane) const {
    return (plane - origin_[axis]) * inverse_[axis];
  }
  HOST_DEVICE static Float3 as_numbers(Int3 i) {
    return {static_cast<float>(i.x), static_cast<float>(i.y), static_cast<float>(i.z)};
  }

  /// Over empty bricks: `skip` of them along each axis in the ray's direction, this one included.
  HOST_DEVICE void jump(Int3 brick, std::int32_t skip, const ExactView& exact) {
    const auto border = [skip](std::int32_t b, float direction) {
      return (b + (direction > 0.0f ? skip : 1 - skip)) * (1 << kBrickShift);
    };
    const std::int32_t px = border(brick.x, direction_.x), py = border(brick.y, direction_.y),
                       pz = border(brick.z, direction_.z);
    const float x = plane_distance(0, static_cast<float>(px));
    const float y = plane_distance(1, static_cast<float>(py));
    const float z = plane_distance(2, static_cast<float>(pz));
    t_ = larger(t_, smaller(x, smaller(y, z)));
    const Float3 p = origin_ + direction_ * t_;
    // Along the axis of the border the cell is known exactly. The others come from a rounded
    // position, which may lie a cell back: never go back, or a ray through a corner would not end.
    Int3 on{forward(direction_.x, cell_.x, cell_at(p.x, exact.size.x)),
            forward(direction_.y, cell_.y, cell_at(p.y, exact.size.y)),
            forward(direction_.z, cell_.z, cell_at(p.z, exact.size.z))};
    if (x <= y && x <= z) {
      on.x = px - 1 + up(direction_.x);
    } else if (y <= z) {
      on.y = py - 1 + up(direction_.y);
    } else {
      on.z = pz - 1 + up(direction_.z);
    }
    cell_ = on;
    new_brick_ = true;
  }
  HOST_DEVICE static std::int32_t forward(float direction, std::int32_t a, std::int32_t b) {
    return direction > 0.0f ? larger(a, b) : smaller(a, b);
  }

  Float3 origin_, direction_, inverse_;  ///< in cells
  Float3 bias_;                          ///< planes of the cell at 0: where the ray meets them, mm
  float t_, last_;
  Int3 cell_;
  std::int32_t octant_;  ///< of ExactView::skips: where the ray's octant begins
  bool new_brick_ = true;
  typename Volume::Brick brick_;
};

}  // namespace diaphane::render
