#pragma once

#include "renderd/kernel/exact_cell.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"

namespace diaphane::render {

/// A cell of a ray's way.
struct CellCrossing {
  Crossing way;
  Int3 cell;
  std::int32_t brick;  ///< index of its brick
};

/// The cells between voxel centres along a ray, in order, without those of bricks where nothing is.
/// Cell (i, j, k) has the voxels i - 1 and i along x as corners (clamped at the edges), i from 0 to
/// the number of voxels, and so on.
///
/// Cells are counted in integers, a distance comes from an integer plane and not from the one
/// before, and never goes back: rays along axes, through edges and corners, from inside and of zero
/// components all end. A component of zero is made 1e-20: it reaches no plane.
class ExactWalk {
 public:
  ExactWalk() = default;  ///< to be assigned to
  HOST_DEVICE ExactWalk(const Ray& ray, Span span, const ExactView& exact)
      : origin_(ray.origin + Float3{0.5f, 0.5f, 0.5f}),
        direction_{away_from_zero(ray.direction.x), away_from_zero(ray.direction.y),
                   away_from_zero(ray.direction.z)},
        inverse_{1.0f / direction_.x, 1.0f / direction_.y, 1.0f / direction_.z},
        t_(span.begin),
        last_(span.end) {
    const std::int32_t octant = (direction_.x > 0.0f ? 1 : 0) | (direction_.y > 0.0f ? 2 : 0) |
                                (direction_.z > 0.0f ? 4 : 0);
    skips_ = exact.skips + std::int64_t{octant} * exact.brick_count;
    const Float3 p = origin_ + direction_ * t_;
    put(Int3{cell_at(p.x, exact.size.x), cell_at(p.y, exact.size.y), cell_at(p.z, exact.size.z)});
  }

  HOST_DEVICE bool ended() const { return !(t_ < last_); }

  /// One step, until it has ended: true when it was across a cell where something may be, false
  /// when over empty bricks.
  HOST_DEVICE bool advance(const ExactView& exact, CellCrossing& out) {
    const Int3 brick{cell_.x >> kBrickShift, cell_.y >> kBrickShift, cell_.z >> kBrickShift};
    const std::int32_t index = brick.x + exact.bricks.x * (brick.y + exact.bricks.y * brick.z);
    const std::int32_t skip = skips_[index];
    if (skip != 0) {
      jump(brick, skip, exact);
      return false;
    }
    out.cell = cell_;
    out.brick = index;
    cross(exact, out.way);
    return true;
  }

  /// The next cell where something may be; false when the ray has left.
  HOST_DEVICE bool next(const ExactView& exact, CellCrossing& out) {
    while (!ended()) {
      if (advance(exact, out)) return true;
    }
    return false;
  }

 private:
  HOST_DEVICE static float away_from_zero(float d) {
    return fabsf(d) < 1e-20f ? (d < 0.0f ? -1e-20f : 1e-20f) : d;
  }
  HOST_DEVICE static std::int32_t up(float direction) { return direction > 0.0f ? 1 : 0; }
  /// The comparison sends what is below the grid, and NaN, to 0.
  HOST_DEVICE static std::int32_t cell_at(float p, std::int32_t size) {
    return p > 0.0f ? static_cast<std::int32_t>(smaller(p, static_cast<float>(size))) : 0;
  }
  HOST_DEVICE float plane_distance(int axis, float plane) const {
    return (plane - origin_[axis]) * inverse_[axis];
  }
  HOST_DEVICE void put(Int3 cell) {
    cell_ = cell;
    corner_ = {static_cast<float>(cell.x), static_cast<float>(cell.y), static_cast<float>(cell.z)};
  }
  HOST_DEVICE static float ahead(float direction) { return direction > 0.0f ? 1.0f : 0.0f; }
  HOST_DEVICE static std::int32_t sign(float direction) { return direction > 0.0f ? 1 : -1; }
  HOST_DEVICE static float sign_f(float direction) { return direction > 0.0f ? 1.0f : -1.0f; }

  /// The way through the cell, and on to its neighbour.
  HOST_DEVICE void cross(const ExactView& exact, Crossing& way) {
    const float x = plane_distance(0, corner_.x + ahead(direction_.x));
    const float y = plane_distance(1, corner_.y + ahead(direction_.y));
    const float z = plane_distance(2, corner_.z + ahead(direction_.z));
    way.entry = origin_ + direction_ * t_ - corner_;
    way.slope = direction_;
    way.t0 = t_;
    const float end = larger(t_, smaller(x, smaller(y, z)));
    way.t1 = smaller(last_, end);
    t_ = end;
    if (x <= y && x <= z) {
      cell_.x += sign(direction_.x);
      corner_.x += sign_f(direction_.x);
      leave_unless_within(cell_.x, exact.size.x);
    } else if (y <= z) {
      cell_.y += sign(direction_.y);
      corner_.y += sign_f(direction_.y);
      leave_unless_within(cell_.y, exact.size.y);
    } else {
      cell_.z += sign(direction_.z);
      corner_.z += sign_f(direction_.z);
      leave_unless_within(cell_.z, exact.size.z);
    }
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
      leave_unless_within(on.x, exact.size.x);
    } else if (y <= z) {
      on.y = py - 1 + up(direction_.y);
      leave_unless_within(on.y, exact.size.y);
    } else {
      on.z = pz - 1 + up(direction_.z);
      leave_unless_within(on.z, exact.size.z);
    }
    put(on);
  }
  HOST_DEVICE static std::int32_t forward(float direction, std::int32_t a, std::int32_t b) {
    return direction > 0.0f ? larger(a, b) : smaller(a, b);
  }
  HOST_DEVICE void leave_unless_within(std::int32_t cell, std::int32_t size) {
    if (static_cast<std::uint32_t>(cell) > static_cast<std::uint32_t>(size)) t_ = last_;
  }

  Float3 origin_, direction_, inverse_;  ///< in cells
  float t_, last_;
  Int3 cell_;
  Float3 corner_;  ///< the same as numbers that planes are found from: converting costs
  const std::uint8_t* skips_;
};

}  // namespace diaphane::render
