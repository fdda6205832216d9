#pragma once

#include <cuda_runtime_api.h>

#include "renderd/engine/cuda_trace_types.h"
#include "renderd/scene/grid.h"

// What is derived of voxels and of the transfer function on the device. Each function queues its
// kernels on a stream and returns the status of the launch.

namespace diaphane::render::cuda {

/// Range of values of each macrocell, as make_value_grid gives, and of all voxels.
cudaError_t value_ranges(const TextureVolume& volume, Int3 cells, ValueRange* ranges,
                         std::int32_t* low_high, cudaStream_t stream);

/// What a rebuild found; the contents of kNothingFound before it.
struct CellSummary {
  std::int32_t low[3], high[3];  ///< cells whose majorant is not 0, both included
  std::uint32_t occupied;        ///< their number
  float widest;                  ///< largest majorant - minorant
};
inline constexpr CellSummary kNothingFound{{1 << 30, 1 << 30, 1 << 30}, {-1, -1, -1}, 0, 0.0f};

/// A table's extrema over runs of 2^r nodes, row r after row r - 1: TransferView::extinction, of
/// which row 0 is there, and the same of minima, from row 1 on.
struct TableRows {
  float* maxima;
  float* minima;
  std::int32_t count;  ///< nodes
};
/// floor(log2(count)) + 1
constexpr std::int32_t rows_of(std::int32_t count) {
  std::int32_t rows = 1;
  while (count >> rows != 0) ++rows;
  return rows;
}
cudaError_t fill_rows(const TableRows& table, cudaStream_t stream);

/// Where values lie in the table: PreparedTransfer's numbers.
struct ValueMapping {
  std::int32_t minimum;  ///< the value of node 0
  double scale, margin;
};
/// Bounds of the extinction in each cell, to the last bit as bound_cells of scene/transfer.cpp.
cudaError_t bound_cells(const ValueRange* ranges, Int3 cells, const TableRows& table,
                        const ValueMapping& mapping, CellBounds* bounds, CellSummary* summary,
                        cudaStream_t stream);

}  // namespace diaphane::render::cuda
