#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "volume/volume.h"

namespace diaphane::ingest {

/// One byte per cell: 0 or 1.
using CellMask = std::vector<std::uint8_t>;

/// Groups of whole voxels of about kCellMm. The axes are the volume's own, in the order and
/// direction nearest to the patient's: x to the left, y to the back, z to the head. Unlike Coarse
/// (ingest/head/coarse.h), every voxel counts, because a skin or a table's shell is thinner than a
/// cell.
struct Cells {
  static constexpr double kCellMm = 2.2;

  std::array<int, 3> size{};
  std::array<double, 3> mm{};                       ///< edges of a cell
  std::array<std::vector<std::size_t>, 3> offsets;  ///< terms of a cell's index, see cell_of
  /// The voxel axis along patient axis p is axis[p]. Its indices run backwards if flipped[p].
  std::array<std::size_t, 3> axis{};
  std::array<bool, 3> flipped{};
  std::array<int, 3> voxels_per_cell{};  ///< along patient axes

  std::vector<std::uint8_t> matter;  ///< share of the voxels at or above the threshold, in eighths
  std::vector<std::int16_t> mean;

  std::size_t count() const { return matter.size(); }
  std::size_t level() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
  }
  std::size_t at(int x, int y, int z) const {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(size[0]) *
               (static_cast<std::size_t>(y) +
                static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(z));
  }
  std::array<int, 3> place(std::size_t cell) const {
    const auto width = static_cast<std::size_t>(size[0]), area = level();
    return {static_cast<int>(cell % width), static_cast<int>(cell % area / width),
            static_cast<int>(cell / area)};
  }
  /// The cell of voxel (i, j, k) is offsets[0][i] + offsets[1][j] + offsets[2][k].
  std::size_t cell_of(std::size_t i, std::size_t j, std::size_t k) const {
    return offsets[0][i] + offsets[1][j] + offsets[2][k];
  }
  /// Returns how many cells `mm_wide` spans along each axis, at least 1.
  std::array<int, 3> radius(double mm_wide) const;
  double cell_volume() const { return mm[0] * mm[1] * mm[2]; }
};

Cells make_cells(const volume::Volume& volume, int threshold);

/// Dilates or erodes by a box of `radius` cells. Cells outside of the grid equal those at its
/// border.
CellMask dilated(const Cells& cells, CellMask mask, const std::array<int, 3>& radius);
CellMask eroded(const Cells& cells, CellMask mask, const std::array<int, 3>& radius);

/// Dilates `seed` within `mask` by `steps` steps over the 26 neighbours of a cell.
CellMask grown_within(const Cells& cells, CellMask seed, const CellMask& mask, int steps);

/// Whether filled() closes a short gap of a level's border between two parts of a mask, such as
/// where the field of view cuts a body.
enum class Border { kOpen, kClosed };
/// Returns `mask` with the holes of each axial level filled.
CellMask filled(const Cells& cells, const CellMask& mask, Border border);

/// Indices of cells. A volume has fewer than 2^32 voxels (ScanLimits::most_voxels).
using CellList = std::vector<std::uint32_t>;

/// The connected components (26 neighbours) of a mask.
struct Components {
  std::vector<std::int32_t> label;  ///< per cell: index in `members`, or -1
  std::vector<CellList> members;    ///< cells of each component
};
Components components(const Cells& cells, const CellMask& mask);

/// Adds `n` cells or voxels of one mask to another. They must not overlap.
void or_into(std::uint8_t* to, const std::uint8_t* from, std::size_t n);

std::size_t count(const CellMask& mask);

}  // namespace diaphane::ingest
