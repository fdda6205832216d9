#pragma once

#include <cuda_runtime_api.h>

#include "renderd/engine/cuda/trace_types.h"
#include "renderd/kernel/overlay.h"
#include "renderd/scene/grid.h"
#include "renderd/scene/labels.h"

// Kernels that bound values and extinction per macrocell. Each function queues its kernels on a
// stream and returns the status of the launch.

namespace diaphane::render::cuda {

/// Computes the range of values of each macrocell, like make_value_grid(), and widens `low_high` to
/// the range of all voxels.
cudaError_t value_ranges(const TextureVolume& volume, Int3 cells, ValueRange* ranges,
                         std::int32_t* low_high, cudaStream_t stream);

/// The result of bound_cells() over all cells, which must be kNothingFound before the call.
struct CellSummary {
  std::int32_t low[3], high[3];  ///< range of the cells whose majorant is not 0, both ends included
  std::uint32_t occupied;        ///< number of these cells
  float widest;                  ///< largest majorant - minorant
};
inline constexpr CellSummary kNothingFound{{1 << 30, 1 << 30, 1 << 30}, {-1, -1, -1}, 0, 0.0f};

/// The extrema of the extinction table over runs of 2^r nodes, row r after row r - 1. The maxima
/// are TransferView::extinction, whose row 0 is the table. The minima begin with row 1.
struct TableRows {
  float* maxima;
  float* minima;
  std::int32_t count;  ///< nodes
};
/// Returns the number of rows of a table of `count` nodes: floor(log2(count)) + 1.
constexpr std::int32_t rows_of(std::int32_t count) {
  std::int32_t rows = 1;
  while (count >> rows != 0) ++rows;
  return rows;
}
cudaError_t fill_rows(const TableRows& table, cudaStream_t stream);

/// The mapping from voxel values to nodes of the table, with the numbers of PreparedTransfer.
struct ValueMapping {
  std::int32_t minimum;  ///< the value of node 0
  double scale, margin;
};
/// The opacities of the labels in each cell. The pointers are null if the scene has no labels.
struct CellLabels {
  const std::uint32_t* set_of_cell = nullptr;  ///< LabelGrid::set_of_cell
  const LabelRange* ranges = nullptr;          ///< PreparedLabels::ranges
};
/// Computes the bounds of the extinction in each cell. They equal the results of bound_cells() in
/// scene/transfer.cpp, or with labels of prepare_labels() in scene/labels.cpp, to the last bit.
cudaError_t bound_cells(const ValueRange* ranges, Int3 cells, const TableRows& table,
                        const ValueMapping& mapping, const CellLabels& labels, CellBounds* bounds,
                        CellSummary* summary, cudaStream_t stream);

/// The second scan of a scene, for add_second().
struct SecondCells {
  AffineMap map;             ///< OverlayView::map
  const CellBounds* bounds;  ///< of the second scan's own cells
  Int3 cells, size;          ///< of the second scan
  bool split;
  MatterShares<true> shares;
};
/// Adds the second scan to the bounds of each cell, and computes OverlayView::majorants. They equal
/// the results of prepare_overlay(). `summary` must be kNothingFound before the call.
cudaError_t add_second(const SecondCells& second, Int3 cells, CellBounds* bounds, float* majorants,
                       CellSummary* summary, cudaStream_t stream);

}  // namespace diaphane::render::cuda
