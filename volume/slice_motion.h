#pragma once

#include <cstddef>
#include <vector>

namespace diaphane::volume {

/// A picture of floating-point numbers in rows.
struct SliceImage {
  int width = 0, height = 0;
  std::vector<float> values;

  SliceImage() = default;
  SliceImage(int columns, int rows)
      : width(columns), height(rows), values(static_cast<std::size_t>(columns) * rows) {}
  float* row(int y) { return values.data() + static_cast<std::size_t>(y) * width; }
  const float* row(int y) const { return values.data() + static_cast<std::size_t>(y) * width; }
};

/// Returns the value at column x and row y by bilinear interpolation. Positions outside the image
/// are clamped to its border.
inline float sample(const SliceImage& plane, float x, float y) {
  const float most_x = static_cast<float>(plane.width - 1);
  const float most_y = static_cast<float>(plane.height - 1);
  x = x > 0 ? (x < most_x ? x : most_x) : 0;
  y = y > 0 ? (y < most_y ? y : most_y) : 0;
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const int right = left + 1 < plane.width ? left + 1 : left;
  const float* const upper = plane.row(top);
  const float* const lower = plane.row(top + 1 < plane.height ? top + 1 : top);
  const float across = x - static_cast<float>(left), down = y - static_cast<float>(top);
  const float above = upper[left] + across * (upper[right] - upper[left]);
  const float below = lower[left] + across * (lower[right] - lower[left]);
  return above + down * (below - above);
}

/// Motion between two slices in pixels: p - motion / 2 in the first is p + motion / 2 in the
/// second.
struct Motion {
  SliceImage x, y;
};

/// Estimates the motion between two slices of equal size whose values are mostly in [0, 1].
Motion estimate_motion(const SliceImage& first, const SliceImage& second);

}  // namespace diaphane::volume
