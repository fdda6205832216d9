#pragma once

#include "renderd/kernel/views.h"
#include "renderd/math/vector.h"

// Exact extinction and optical depth in one cell between voxel centres. Along a ray through the
// cell, the interpolated value is a cubic. Wherever the extinction is linear in the value, two
// Gauss points therefore integrate it without error. A cell whose values span several linear pieces
// of the extinction function is split where the cubic crosses their borders. A border misplaced by
// d causes an error of the order of d^2, since the function is continuous there.

namespace diaphane::render {

/// Voxel values at the corners of a cell; bit 0 of the index is x, bit 1 y, bit 2 z.
struct Corners {
  float v[8];

  /// Returns the value at `p` in [0, 1]^3, the position in the cell.
  HOST_DEVICE float at(Float3 p) const {
    const float v00 = v[0] + p.x * (v[1] - v[0]), v10 = v[2] + p.x * (v[3] - v[2]);
    const float v01 = v[4] + p.x * (v[5] - v[4]), v11 = v[6] + p.x * (v[7] - v[6]);
    const float v0 = v00 + p.y * (v10 - v00), v1 = v01 + p.y * (v11 - v01);
    return v0 + p.z * (v1 - v0);
  }
};

/// Smallest and largest voxel value at the corners of a cell.
struct CornerRange {
  std::int32_t low, high;
};

/// The segment of a ray in a cell, from t0 to t1 (mm). `origin` is the ray's origin relative to the
/// cell's lower corner, and `direction` is per mm.
struct Crossing {
  Float3 origin, direction;
  float t0, t1;

  /// Returns the position in the cell.
  HOST_DEVICE Float3 at(float t) const { return origin + direction * t; }
};

/// Returns the extinction at a value within a linear piece.
HOST_DEVICE float extinction_in(const ExtinctionPiece& piece, float value) {
  return fast_max(piece.extinction + piece.slope * (value - piece.begin), 0.0f);
}

/// First node of the two-point Gauss quadrature on [0, 1]; the second one is its mirror image.
inline constexpr float kGaussNode = 0.21132486540518713f;

/// Returns the optical depth from ta to tb, exactly if all values in between lie in the piece.
HOST_DEVICE float depth_between(const Corners& corners, const Crossing& segment,
                                const ExtinctionPiece& piece, float ta, float tb) {
  const float length = tb - ta;
  const float a = extinction_in(piece, corners.at(segment.at(ta + kGaussNode * length)));
  const float b = extinction_in(piece, corners.at(segment.at(tb - kGaussNode * length)));
  return 0.5f * length * (a + b);
}

/// Returns the distance in [ta, tb] at which the optical depth from ta reaches `target`. `target`
/// is at most depth_between(). Inverts a quartic by Newton steps within a bracket.
HOST_DEVICE float invert_depth(const Corners& corners, const Crossing& segment,
                               const ExtinctionPiece& piece, float ta, float tb, float target) {
  const float length = tb - ta;
  const float e0 = extinction_in(piece, corners.at(segment.at(ta)));
  const float e1 = extinction_in(piece, corners.at(segment.at(ta + length * (1.0f / 3))));
  const float e2 = extinction_in(piece, corners.at(segment.at(tb - length * (1.0f / 3))));
  const float e3 = extinction_in(piece, corners.at(segment.at(tb)));
  // The cubic through the four values, in powers of s in [0, 1].
  const float c1 = -5.5f * e0 + 9.0f * e1 - 4.5f * e2 + e3;
  const float c2 = 9.0f * e0 - 22.5f * e1 + 18.0f * e2 - 4.5f * e3;
  const float c3 = -4.5f * e0 + 13.5f * e1 - 13.5f * e2 + 4.5f * e3;
  const float total = length * (e0 + c1 * 0.5f + c2 * (1.0f / 3) + c3 * 0.25f);
  float low = 0.0f, high = 1.0f;
  float s = total > 0.0f ? min(quotient_near(target, total), 1.0f) : 1.0f;
  DEVICE_NO_UNROLL
  for (int i = 0; i < 8; ++i) {
    const float depth =
        length * s * (e0 + s * (c1 * 0.5f + s * (c2 * (1.0f / 3) + s * (c3 * 0.25f))));
    const float excess = depth - target;
    // This test comes before the bracket moves. Otherwise a correct position would become an end of
    // the bracket, and bisection would leave it again.
    if (fabsf(excess) <= 1e-6f * target) break;
    if (excess > 0.0f) {
      high = s;
    } else {
      low = s;
    }
    const float slope = length * (e0 + s * (c1 + s * (c2 + s * c3)));
    const float next = s - quotient_near(excess, slope);
    // NaN (slope 0) fails the comparison too.
    s = next > low && next < high ? next : 0.5f * (low + high);
  }
  return ta + s * length;
}

/// The value along a crossing as a cubic in s = (t - t0) / (t1 - t0).
struct ValueCubic {
  float c0, c1, c2, c3;

  ValueCubic() = default;  ///< uninitialised; assign before use
  HOST_DEVICE ValueCubic(const Corners& c, const Crossing& segment) {
    const float length = segment.t1 - segment.t0;
    const Float3 p = segment.at(segment.t0), d = segment.direction * length;
    const float* v = c.v;
    const float bx = v[1] - v[0], by = v[2] - v[0], bz = v[4] - v[0];
    const float cxy = v[3] - v[1] - by, czx = v[5] - v[4] - bx, cyz = v[6] - v[2] - bz;
    const float e = (v[7] - v[6]) - (v[5] - v[4]) - (v[3] - v[2]) + (v[1] - v[0]);
    c0 = c.at(p);
    // Derivatives at the entry.
    const float gx = bx + cxy * p.y + czx * p.z + e * p.y * p.z;
    const float gy = by + cxy * p.x + cyz * p.z + e * p.x * p.z;
    const float gz = bz + czx * p.x + cyz * p.y + e * p.x * p.y;
    c1 = gx * d.x + gy * d.y + gz * d.z;
    c2 = (cxy + e * p.z) * d.x * d.y + (cyz + e * p.x) * d.y * d.z + (czx + e * p.y) * d.x * d.z;
    c3 = e * d.x * d.y * d.z;
  }
  HOST_DEVICE float at(float s) const { return c0 + s * (c1 + s * (c2 + s * c3)); }
  HOST_DEVICE float derivative(float s) const { return c1 + s * (2.0f * c2 + s * 3.0f * c3); }

  /// The control points in Bernstein form. They bound the values of the cubic on [0, 1], and the
  /// cubic is monotone if they are.
  struct Hull {
    float first, second, third, last;

    HOST_DEVICE ValueSpan range() const {
      return {min(min(first, second), min(third, last)), max(max(first, second), max(third, last))};
    }
    HOST_DEVICE bool monotone() const {
      return (first <= second && second <= third && third <= last) ||
             (first >= second && second >= third && third >= last);
    }
  };
  HOST_DEVICE Hull hull() const {
    const float third = c1 * (1.0f / 3);
    const float second = c0 + third;
    return {c0, second, second + third + c2 * (1.0f / 3), c0 + c1 + c2 + c3};
  }

  /// Computes the extrema of the cubic within (0, 1) in ascending order; 1 stands for none.
  HOST_DEVICE void turns(float& first, float& second) const {
    first = second = 1.0f;
    const float a = 3.0f * c3, b = c2, c = c1;  // a s^2 + 2 b s + c
    const float discriminant = b * b - a * c;
    if (!(discriminant > 0.0f)) return;
    const float q = -(b + (b < 0.0f ? -sqrtf(discriminant) : sqrtf(discriminant)));
    float r = q / a, s = c / q;
    if (!(r > 0.0f && r < 1.0f)) r = 1.0f;
    if (!(s > 0.0f && s < 1.0f)) s = 1.0f;
    first = min(r, s);
    second = max(r, s);
  }

  /// Returns the s between a and b at which the cubic reaches `value`. The cubic must be monotone
  /// there, with the values `from` and `to` at the ends. The error of at most 3e-5 affects the
  /// optical depth by the order of its square.
  HOST_DEVICE float meets(float value, float a, float from, float b, float to) const {
    const bool rising = to > from;
    float s = a + (b - a) * quotient_near(value - from, to - from);
    if (!(s > a && s < b)) s = 0.5f * (a + b);
    DEVICE_NO_UNROLL
    for (int i = 0; i < 20; ++i) {
      const float excess = at(s) - value;
      if (excess == 0.0f) break;
      if ((excess > 0.0f) == rising) {
        b = s;
      } else {
        a = s;
      }
      const float next = s - quotient_near(excess, derivative(s));
      const float last = s;
      s = next > a && next < b ? next : 0.5f * (a + b);
      if (fabsf(s - last) < 3e-5f) break;
    }
    return s;
  }
};

/// Walks, in order, the parts of a crossing in which the extinction is linear in the value. A part
/// ends where the value enters another piece of the extinction or turns.
class PartsWalk {
 public:
  struct Part {
    ExtinctionPiece piece;
    float begin, end;  ///< s of ValueCubic
  };

  PartsWalk() = default;  ///< uninitialised; assign before use
  HOST_DEVICE PartsWalk(const Corners& corners, const Crossing& segment, const ExactView& exact)
      : cubic_(corners, segment) {
    const ValueCubic::Hull hull = cubic_.hull();
    if (!hull.monotone()) cubic_.turns(leg_end_, next_turn_);
    piece_ = exact.piece_at(cubic_.c0);
    const bool falls = cubic_.at(leg_end_) < cubic_.c0;
    if (falls && piece_ > 0 && cubic_.c0 <= exact.pieces[piece_].begin) --piece_;
    // The values along the ray span less than those of the cell, and often lie in a single piece.
    const ValueSpan range = hull.range();
    const ExtinctionPiece piece = exact.pieces[piece_];
    if (range.low >= piece.begin && range.high <= piece.end) leg_end_ = next_turn_ = 1.0f;
  }

  HOST_DEVICE bool ended() const { return !(at_ < 1.0f); }
  HOST_DEVICE Part next(const ExactView& exact) {
    const Part part = part_up_to_border(exact);
    at_ = max(at_, part.end);
    return part;
  }
  /// Returns the optical depth of a part of a crossing that is `length` mm long. The result is
  /// exact, because the extinction along a part is a cubic.
  HOST_DEVICE float depth_of(const Part& part, float length) const {
    const float share = part.end - part.begin;
    const float a = extinction_in(part.piece, cubic_.at(part.begin + kGaussNode * share));
    const float b = extinction_in(part.piece, cubic_.at(part.end - kGaussNode * share));
    return 0.5f * length * share * (a + b);
  }

 private:
  HOST_DEVICE Part part_up_to_border(const ExactView& exact) {
    const ExtinctionPiece piece = exact.pieces[piece_];
    const float from = cubic_.at(at_), to = cubic_.at(leg_end_);
    const bool rises = to > from;
    const float border = rises ? piece.end : piece.begin;
    const bool crossed =
        rises ? border < to && piece_ + 1 < exact.piece_count : border > to && piece_ > 0;
    if (crossed) {
      piece_ += rises ? 1 : -1;
      return {piece, at_, cubic_.meets(border, at_, from, leg_end_, to)};
    }
    const Part rest{piece, at_, leg_end_};
    leg_end_ = next_turn_;
    next_turn_ = 1.0f;
    return rest;
  }

  ValueCubic cubic_;
  float at_ = 0.0f, leg_end_ = 1.0f, next_turn_ = 1.0f;
  std::int32_t piece_;
};

/// Finds the piece that contains all values of a cell. Returns false if they span several pieces.
HOST_DEVICE bool one_piece(const ExactView& exact, CornerRange range, ExtinctionPiece& piece) {
  piece = exact.pieces[exact.piece_of[range.low - exact.first_value]];
  return static_cast<float>(range.high) <= piece.end;
}

/// Returns the optical depth of a crossing of a cell whose values all lie in one piece.
HOST_DEVICE float depth_in(const ExtinctionPiece& piece, const Corners& corners,
                           const Crossing& segment) {
  return depth_between(corners, segment, piece, segment.t0, segment.t1);
}

/// Returns the distance at which the optical depth from segment.t0 reaches `target`, which is at
/// most the optical depth of the crossing.
template <bool Curves>
HOST_DEVICE float place_in_cell(const Corners& corners, const Crossing& segment,
                                const ExactView& exact, float target) {
  if constexpr (!Curves) {
    return invert_depth(corners, segment, exact.only, segment.t0, segment.t1, target);
  } else {
    const float length = segment.t1 - segment.t0;
    PartsWalk parts(corners, segment, exact);
    while (!parts.ended()) {
      const PartsWalk::Part part = parts.next(exact);
      const float depth = parts.depth_of(part, length);
      if (depth >= target) {
        return invert_depth(corners, segment, part.piece, segment.t0 + part.begin * length,
                            segment.t0 + part.end * length, target);
      }
      target -= depth;
    }
    return segment.t1;
  }
}

}  // namespace diaphane::render
