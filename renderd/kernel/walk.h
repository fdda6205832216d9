#pragma once

#include "renderd/kernel/views.h"
#include "renderd/math/vector.h"

namespace diaphane::render {

/// A ray in voxel indices; `direction` is in voxels per mm along the ray, so that the parameter is
/// in mm.
struct Ray {
  Float3 origin, direction;

  HOST_DEVICE Float3 at(float t) const { return origin + direction * t; }
};

/// An interval along a ray, mm; empty if begin >= end.
struct Span {
  float begin, end;
};

HOST_DEVICE void clip_axis(Span& span, float origin, float direction, float low, float high) {
  if (direction == 0.0f) {  // also -0; avoids a division by 0
    if (origin < low || origin > high) span.end = span.begin;
    return;
  }
  const float inverse = 1.0f / direction;
  const float a = (low - origin) * inverse, b = (high - origin) * inverse;
  span.begin = max(span.begin, min(a, b));
  span.end = min(span.end, max(a, b));
}

/// Returns the part of `span` inside `box`.
HOST_DEVICE Span clip(const Ray& ray, const Box& box, Span span) {
  clip_axis(span, ray.origin.x, ray.direction.x, box.low.x, box.high.x);
  clip_axis(span, ray.origin.y, ray.direction.y, box.low.y, box.high.y);
  clip_axis(span, ray.origin.z, ray.direction.z, box.low.z, box.high.z);
  return span;
}

/// Walks the cells of edge `Edge` of a grid along a ray in order (Amanatides and Woo 1987). Cells
/// are counted in integers and the distance never decreases, so all rays end, even rays that start
/// inside, run along axes or pass through edges and corners. Due to rounding, a position inside the
/// piece [begin, end) may lie outside the cell. With `Coordinates`, the cell is identified by its
/// three indices instead of one.
template <int Edge, bool Coordinates>
class GridWalk {
 public:
  HOST_DEVICE GridWalk(const Ray& ray, Span span, Int3 size) : begin_(span.begin), last_(span.end) {
    const Float3 p = ray.at(span.begin);
    const std::int32_t x = start(0, p.x, ray.origin.x, ray.direction.x, size.x, 1);
    const std::int32_t y = start(1, p.y, ray.origin.y, ray.direction.y, size.y, size.x);
    const std::int32_t z = start(2, p.z, ray.origin.z, ray.direction.z, size.z, size.x * size.y);
    if constexpr (Coordinates) {
      cell_[0] = x;
      cell_[1] = y;
      cell_[2] = z;
    } else {
      cell_[0] = x + size.x * (y + size.y * z);
    }
    find_end();
  }

  /// Returns the index of the cell, x fastest.
  HOST_DEVICE std::int32_t cell() const { return cell_[0]; }
  HOST_DEVICE Int3 coordinates() const requires Coordinates {
    return {cell_[0], cell_[1], cell_[2]};
  }
  HOST_DEVICE float begin() const { return begin_; }
  HOST_DEVICE float end() const { return end_; }

  /// Moves to the next cell. Returns false at the end of the span or the grid.
  HOST_DEVICE bool advance() {
    if (end_ >= last_) return false;
    begin_ = end_;
    if (next_[0] <= next_[1] && next_[0] <= next_[2]) {
      if (!step(0)) return false;
    } else if (next_[1] <= next_[2]) {
      if (!step(1)) return false;
    } else {
      if (!step(2)) return false;
    }
    find_end();
    return true;
  }

 private:
  HOST_DEVICE std::int32_t start(int axis, float position, float origin, float direction,
                                 std::int32_t size, std::int32_t stride) {
    const float scaled = position * (1.0f / Edge);
    // The comparison maps positions below the grid and NaN to 0.
    std::int32_t i = scaled > 0.0f ? static_cast<std::int32_t>(min(scaled, 1e9f)) : 0;
    i = min(i, size - 1);
    if constexpr (Coordinates) stride = 1;
    if (direction == 0.0f) {
      next_[axis] = delta_[axis] = 3.4e38f;
      left_[axis] = 1;
      stride_[axis] = 0;
      return i;
    }
    const float inverse = 1.0f / direction;
    const bool up = direction > 0.0f;
    next_[axis] = (static_cast<float>((i + (up ? 1 : 0)) * Edge) - origin) * inverse;
    delta_[axis] = static_cast<float>(Edge) * (up ? inverse : -inverse);
    left_[axis] = up ? size - i : i + 1;
    stride_[axis] = up ? stride : -stride;
    return i;
  }
  HOST_DEVICE bool step(int axis) {
    next_[axis] += delta_[axis];
    cell_[Coordinates ? axis : 0] += stride_[axis];
    return --left_[axis] > 0;
  }
  HOST_DEVICE void find_end() {
    end_ = max(begin_, min(last_, min(next_[0], min(next_[1], next_[2]))));
  }

  float begin_, end_, last_;
  float next_[3], delta_[3];
  std::int32_t left_[3], stride_[3];
  std::int32_t cell_[Coordinates ? 3 : 1];
};

/// Walks the macrocells. Their bounds also hold half a voxel outside, so rounding does no harm.
class CellWalk : public GridWalk<kCellSize, false> {
 public:
  HOST_DEVICE CellWalk(const Ray& ray, Span span, const GridView& grid)
      : GridWalk(ray, span, grid.size) {}
};

/// Walks the cells between voxel centres, in each of which the value is one trilinear polynomial.
/// Cell (i, j, k) lies below the centre of voxel (i, j, k). Its corners are voxels i - 1 and i
/// along x, clamped at the edges, where i ranges from 0 to the number of voxels, and likewise along
/// y and z.
class VoxelWalk : public GridWalk<1, true> {
 public:
  HOST_DEVICE VoxelWalk(const Ray& ray, Span span, Int3 voxels)
      : GridWalk(Ray{ray.origin + Float3{0.5f, 0.5f, 0.5f}, ray.direction}, span,
                 voxels + Int3{1, 1, 1}) {}
};

}  // namespace diaphane::render
