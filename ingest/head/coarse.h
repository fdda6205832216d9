#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "volume/volume.h"

namespace diaphane::ingest {

/// A volume resampled to cells of kCellMm along the patient's axes: x to the left, y to the back, z
/// to the head. What lies outside of the volume is kNothing.
struct Coarse {
  static constexpr double kCellMm = 3;
  static constexpr float kNothing = -32768;

  std::array<int, 3> size{};
  std::array<double, 3> low{};  ///< mm in the world of scenes: the corner of cell (0, 0, 0)
  std::vector<float> mean;      ///< of eight places in each cell
  std::vector<float> most;

  std::size_t at(int x, int y, int z) const {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(size[0]) *
               (static_cast<std::size_t>(y) +
                static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(z));
  }
  /// The middle of a cell.
  std::array<double, 3> place(int x, int y, int z) const {
    return {low[0] + (x + 0.5) * kCellMm, low[1] + (y + 0.5) * kCellMm,
            low[2] + (z + 0.5) * kCellMm};
  }
  std::size_t cells_of_level() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
  }
};

/// The smallest box along the patient's axes around the volume, mm in the world of scenes.
struct WorldBox {
  std::array<double, 3> low{}, high{};
};
WorldBox world_box(const volume::Header& header);

Coarse coarse_of(const volume::Volume& volume);

/// Cells of one level, by [x + size x * y].
using Mask = std::vector<std::uint8_t>;

/// What of `open` (not 0) can be reached over open cells, by their four neighbours, from the border
/// of the level.
Mask reached_from_border(const Mask& open, int width, int height);
/// The largest piece (four neighbours) of what is not 0, alone; how many cells it has.
std::size_t keep_largest(Mask& mask, int width, int height);

}  // namespace diaphane::ingest
