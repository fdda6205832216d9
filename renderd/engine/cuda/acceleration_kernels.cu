#include "renderd/engine/cuda/acceleration_kernels.h"
#include "renderd/engine/cuda/warp_reduce.cuh"

namespace diaphane::render::cuda {
namespace {

constexpr std::uint32_t kBlock = 256;
constexpr std::uint32_t kWarp = 32;

std::uint32_t blocks_for(std::uint64_t count) {
  return static_cast<std::uint32_t>((count + kBlock - 1) / kBlock);
}

__device__ std::uint64_t thread_index() {
  return std::uint64_t{blockIdx.x} * blockDim.x + threadIdx.x;
}

__device__ Int3 coordinates(std::int32_t cell, Int3 cells) {
  return {cell % cells.x, cell / cells.x % cells.y, cell / cells.x / cells.y};
}

/// Computes the range of cell i, one per warp, from the voxels 8i - 1 to 8i + 8 along each axis.
__global__ void range_kernel(TextureVolume volume, Int3 cells, std::int32_t count,
                             ValueRange* ranges, std::int32_t* low_high) {
  const std::int32_t cell = static_cast<std::int32_t>(thread_index() / kWarp);
  if (cell >= count) return;
  const Int3 c = coordinates(cell, cells);
  const auto first = [](std::int32_t i) { return max(i * kCellSize - 1, 0); };
  const auto end = [](std::int32_t i, std::int32_t n) {
    return min(i * kCellSize + kCellSize, n - 1) + 1;
  };
  const Int3 from{first(c.x), first(c.y), first(c.z)};
  const Int3 size{end(c.x, volume.size.x) - from.x, end(c.y, volume.size.y) - from.y,
                  end(c.z, volume.size.z) - from.z};
  std::int32_t low = 32767, high = -32768;
  for (std::int32_t i = threadIdx.x % kWarp; i < size.x * size.y * size.z; i += kWarp) {
    const Int3 at = coordinates(i, size);
    const std::int32_t value =
        tex3D<short>(volume.texture, static_cast<float>(from.x + at.x),
                     static_cast<float>(from.y + at.y), static_cast<float>(from.z + at.z));
    low = min(low, value);
    high = max(high, value);
  }
  low = warp_min(low);
  high = warp_max(high);
  if (threadIdx.x % kWarp == 0) {
    ranges[cell] = {static_cast<std::int16_t>(low), static_cast<std::int16_t>(high)};
    atomicMin(&low_high[0], low);
    atomicMax(&low_high[1], high);
  }
}

/// Computes row `row` from the previous one. A run that would extend beyond the table is moved back
/// so that it ends with the table.
__global__ void row_kernel(TableRows table, std::int32_t row) {
  const std::int32_t i = static_cast<std::int32_t>(thread_index());
  if (i >= table.count) return;
  const std::int32_t half = 1 << (row - 1);
  const std::int32_t j = min(i, table.count - 2 * half);
  const float* above = table.maxima + std::int64_t{table.count} * (row - 1);
  // There is no row 0 of minima, because it would equal the table.
  const float* below =
      row == 1 ? table.maxima : table.minima + std::int64_t{table.count} * (row - 2);
  table.maxima[std::int64_t{table.count} * row + i] = max(above[j], above[j + half]);
  table.minima[std::int64_t{table.count} * (row - 1) + i] = min(below[j], below[j + half]);
}

__device__ float table_at(const TableRows& table, double x) {
  const std::int32_t node = min(static_cast<std::int32_t>(x), table.count - 2);
  const float w = static_cast<float>(x - static_cast<double>(node));
  const float a = table.maxima[node];
  // Product and sum are rounded separately, as on the host, so that the results are equal.
  return __fadd_rn(a, __fmul_rn(w, __fsub_rn(table.maxima[node + 1], a)));
}

__device__ CellBounds bounds_over(const TableRows& table, double low, double high) {
  const double last = static_cast<double>(table.count - 1);
  low = min(max(low, 0.0), last);
  high = min(max(high, 0.0), last);
  const float a = table_at(table, low), b = table_at(table, high);
  CellBounds bounds{min(a, b), max(a, b)};
  const std::int32_t first_node = static_cast<std::int32_t>(ceil(low));
  const std::int32_t last_node = static_cast<std::int32_t>(floor(high));
  if (first_node > last_node) return bounds;
  const std::int32_t row = 31 - __clz(last_node - first_node + 1);
  const std::int32_t second = last_node + 1 - (1 << row);
  const float* maxima = table.maxima + std::int64_t{table.count} * row;
  const float* minima =
      row == 0 ? table.maxima : table.minima + std::int64_t{table.count} * (row - 1);
  bounds.majorant = max(bounds.majorant, max(maxima[first_node], maxima[second]));
  bounds.minorant = min(bounds.minorant, min(minima[first_node], minima[second]));
  return bounds;
}

/// Adds the bounds of one cell per thread to the summary. All threads of a warp must call it.
__device__ void summarise(CellBounds b, std::int32_t cell, Int3 cells, CellSummary* summary) {
  Int3 low{1 << 30, 1 << 30, 1 << 30}, high{-1, -1, -1};
  if (b.majorant > 0.0f) low = high = coordinates(cell, cells);
  const std::uint32_t occupied = __popc(__ballot_sync(~0u, b.majorant > 0.0f));
  const std::int32_t lows[3] = {warp_min(low.x), warp_min(low.y), warp_min(low.z)};
  const std::int32_t highs[3] = {warp_max(high.x), warp_max(high.y), warp_max(high.z)};
  // Floats that are not negative have the same order as their bits.
  const std::int32_t widest = warp_max(__float_as_int(b.majorant - b.minorant));
  if (threadIdx.x % kWarp != 0 || occupied == 0) return;
  for (int axis = 0; axis < 3; ++axis) {
    atomicMin(&summary->low[axis], lows[axis]);
    atomicMax(&summary->high[axis], highs[axis]);
  }
  atomicAdd(&summary->occupied, occupied);
  atomicMax(reinterpret_cast<std::int32_t*>(&summary->widest), widest);
}

__global__ void bounds_kernel(const ValueRange* ranges, Int3 cells, std::int32_t count,
                              TableRows table, ValueMapping mapping, CellLabels labels,
                              CellBounds* bounds, CellSummary* summary) {
  const std::int32_t cell = static_cast<std::int32_t>(thread_index());
  CellBounds b{0.0f, 0.0f};
  if (cell < count) {
    // Because of rounding, interpolation in the table may leave the range of its nodes.
    constexpr float kUp = 1 + 1e-6f, kDown = 1 - 1e-6f;
    const ValueRange range = ranges[cell];
    b = bounds_over(
        table,
        __dadd_rn(__dmul_rn(range.minimum - mapping.minimum, mapping.scale), -mapping.margin),
        __dadd_rn(__dmul_rn(range.maximum - mapping.minimum, mapping.scale), mapping.margin));
    b = {b.minorant * kDown, b.majorant * kUp};
    if (labels.ranges != nullptr) {
      const LabelRange shown = labels.ranges[labels.set_of_cell[cell]];
      b = {b.minorant * shown.least, b.majorant * shown.most};
    }
    bounds[cell] = b;
  }
  summarise(b, cell, cells, summary);
}

/// Adds the second scan to the bounds of the first in each cell.
__global__ void second_kernel(SecondCells second, Int3 cells, std::int32_t count,
                              CellBounds* bounds, float* majorants, CellSummary* summary) {
  const std::int32_t cell = static_cast<std::int32_t>(thread_index());
  CellBounds b{0.0f, 0.0f};
  if (cell < count) {
    const CellBounds own = second_bounds(second.map, coordinates(cell, cells), second.bounds,
                                         second.cells, second.size);
    b = mixed_bounds(bounds[cell], own, second.split, second.shares);
    majorants[cell] = own.majorant;
    bounds[cell] = b;
  }
  summarise(b, cell, cells, summary);
}

std::int32_t count_of(Int3 cells) { return cells.x * cells.y * cells.z; }

}  // namespace

cudaError_t value_ranges(const TextureVolume& volume, Int3 cells, ValueRange* ranges,
                         std::int32_t* low_high, cudaStream_t stream) {
  const std::int32_t count = count_of(cells);
  range_kernel<<<blocks_for(std::uint64_t{kWarp} * static_cast<std::uint32_t>(count)), kBlock, 0,
                 stream>>>(volume, cells, count, ranges, low_high);
  return cudaGetLastError();
}

cudaError_t fill_rows(const TableRows& table, cudaStream_t stream) {
  const std::uint32_t blocks = blocks_for(static_cast<std::uint32_t>(table.count));
  for (std::int32_t row = 1; row < rows_of(table.count); ++row) {
    row_kernel<<<blocks, kBlock, 0, stream>>>(table, row);
  }
  return cudaGetLastError();
}

cudaError_t bound_cells(const ValueRange* ranges, Int3 cells, const TableRows& table,
                        const ValueMapping& mapping, const CellLabels& labels, CellBounds* bounds,
                        CellSummary* summary, cudaStream_t stream) {
  const std::int32_t count = count_of(cells);
  bounds_kernel<<<blocks_for(static_cast<std::uint32_t>(count)), kBlock, 0, stream>>>(
      ranges, cells, count, table, mapping, labels, bounds, summary);
  return cudaGetLastError();
}

cudaError_t add_second(const SecondCells& second, Int3 cells, CellBounds* bounds, float* majorants,
                       CellSummary* summary, cudaStream_t stream) {
  const std::int32_t count = count_of(cells);
  second_kernel<<<blocks_for(static_cast<std::uint32_t>(count)), kBlock, 0, stream>>>(
      second, cells, count, bounds, majorants, summary);
  return cudaGetLastError();
}

}  // namespace diaphane::render::cuda
