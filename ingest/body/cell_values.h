#pragma once

#include <cstddef>
#include <vector>

#include "ingest/body/cells.h"
#include "volume/labels.h"

namespace diaphane::ingest {

/// The values of the voxels of each cell.
struct CellValues {
  Cells cells;
  std::vector<std::int16_t> least, most;
  CellMask body;  ///< all voxels belong to the body
};
CellValues cell_values(const volume::Volume& volume, const volume::Labels& labels);

/// Calls `visit(cell, voxel, n)` for each run of n voxels of a row that lie in the same cell.
template <typename Visit>
void for_cell_runs(const Cells& cells, const std::array<std::uint32_t, 3>& size, Visit visit) {
  std::vector<std::size_t> starts;
  for (std::size_t x = 0; x < size[0]; ++x) {
    if (x == 0 || cells.offsets[0][x] != cells.offsets[0][x - 1]) starts.push_back(x);
  }
  starts.push_back(size[0]);
  std::size_t row = 0;
  for (std::size_t z = 0; z < size[2]; ++z) {
    for (std::size_t y = 0; y < size[1]; ++y, row += size[0]) {
      const std::size_t base = cells.offsets[1][y] + cells.offsets[2][z];
      for (std::size_t r = 0; r + 1 < starts.size(); ++r) {
        visit(base + cells.offsets[0][starts[r]], row + starts[r], starts[r + 1] - starts[r]);
      }
    }
  }
}

/// Returns `mask` without its components of less than `ml`, or of less than `ml` of the voxels that
/// `voxels` counts per cell.
CellMask without_small(const Cells& cells, const CellMask& mask, double ml);
CellMask without_small(const Cells& cells, const std::vector<std::uint16_t>& voxels,
                       double voxel_ml, double ml);

}  // namespace diaphane::ingest
