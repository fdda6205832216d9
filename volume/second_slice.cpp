#include "volume/second_slice.h"

#include <algorithm>
#include <cmath>

namespace diaphane::volume {
namespace {

/// Returns the value at an index, where the centre of voxel (i, j, k) is at (i, j, k) + 1/2.
std::int16_t value_at(const Volume& volume, const std::array<double, 3>& index) {
  const auto& size = volume.header.size;
  std::array<std::array<std::size_t, 2>, 3> ends{};
  std::array<double, 3> weight{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(index[axis] >= 0 && index[axis] <= size[axis])) return kBlank;
    const double at = std::clamp(index[axis] - 0.5, 0.0, size[axis] - 1.0);
    const double low = std::floor(at);
    weight[axis] = at - low;
    ends[axis] = {static_cast<std::size_t>(low),
                  std::min(static_cast<std::size_t>(low) + 1, std::size_t{size[axis]} - 1)};
  }
  double value = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    double share = 1;
    std::array<std::size_t, 3> voxel{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t end = corner >> axis & 1;
      share *= end == 1 ? weight[axis] : 1 - weight[axis];
      voxel[axis] = ends[axis][end];
    }
    value += share * volume.voxels[voxel[0] + size[0] * (voxel[1] + size[1] * voxel[2])];
  }
  // The value that stands for nothing must not occur inside.
  return static_cast<std::int16_t>(std::max(std::lround(value), long{kBlank} + 1));
}

}  // namespace

PixelGrid pixels_of(const SliceStack& stack, std::uint32_t index) {
  PixelGrid pixels{stack.columns, stack.rows, stack.first, stack.right, stack.down};
  for (std::size_t axis = 0; axis < 3; ++axis) pixels.first[axis] += index * stack.next[axis];
  return pixels;
}

PixelGrid pixels_of(const ObliqueSlice& slice) {
  return {slice.columns, slice.rows, slice.first, slice.right, slice.down};
}

std::vector<std::int16_t> second_slice(const Header& first, const PixelGrid& pixels,
                                       const Volume& second, const Matrix& to_first,
                                       std::span<const std::int16_t> shown) {
  const Matrix map = indices_from_world(first, second.header, to_first);
  std::vector<std::int16_t> values(shown.size(), kBlank);
  for (std::uint32_t row = 0; row < pixels.rows; ++row) {
    for (std::uint32_t column = 0; column < pixels.columns; ++column) {
      const std::size_t pixel = column + std::size_t{pixels.columns} * row;
      if (shown[pixel] == kBlank) continue;
      std::array<double, 3> place{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        place[axis] = pixels.first[axis] + column * pixels.right[axis] + row * pixels.down[axis];
      }
      values[pixel] = value_at(second, moved(map, place));
    }
  }
  return values;
}

}  // namespace diaphane::volume
