#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "volume/volume.h"

namespace diaphane::ingest {

/// A volume resampled to cells of kCellMm along the patient's axes: x to the left, y to the back, z
/// to the head. Cells outside the volume are kNothing.
struct Coarse {
  static constexpr double kCellMm = 3;
  static constexpr float kNothing = -32768;

  std::array<int, 3> size{};
  std::array<double, 3> low{};  ///< mm in world space: the corner of cell (0, 0, 0)
  std::vector<float> mean;      ///< mean of eight samples per cell
  std::vector<float> most;

  std::size_t at(int x, int y, int z) const {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(size[0]) *
               (static_cast<std::size_t>(y) +
                static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(z));
  }
  /// Returns the centre of a cell.
  std::array<double, 3> place(int x, int y, int z) const {
    return {low[0] + (x + 0.5) * kCellMm, low[1] + (y + 0.5) * kCellMm,
            low[2] + (z + 0.5) * kCellMm};
  }
  std::size_t cells_of_level() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
  }
};

/// The smallest box along the patient's axes around the volume, in mm in world space.
struct WorldBox {
  std::array<double, 3> low{}, high{};
};
WorldBox world_box(const volume::Header& header);

Coarse coarse_of(const volume::Volume& volume);

/// Cells of one level, indexed by [x + size x * y].
using Mask = std::vector<std::uint8_t>;

/// Returns the cells of `open` (not 0) that can be reached from the border of the level over
/// four-neighbours in `open`.
Mask reached_from_border(const Mask& open, int width, int height);
/// Keeps only the largest four-connected component of non-zero cells, and returns its number of
/// cells.
std::size_t keep_largest(Mask& mask, int width, int height);

}  // namespace diaphane::ingest
