#pragma once

#include <cuda_runtime_api.h>

#include "renderd/engine/cuda_trace_types.h"
#include "renderd/scene/grid.h"

// What the exact walk needs of voxels and transfer function, made on the device. Each function
// queues its kernels on a stream and returns the status of the launch.

namespace diaphane::render::cuda {

/// Bricks along each axis (ExactView::bricks).
constexpr Int3 bricks_of(Int3 size) {
  return {(size.x >> kBrickShift) + 1, (size.y >> kBrickShift) + 1, (size.z >> kBrickShift) + 1};
}

/// Range of the values at the corners of each brick's cells, as ValueGrid::brick_ranges.
cudaError_t brick_ranges(const TextureVolume& volume, Int3 bricks, ValueRange* ranges,
                         cudaStream_t stream);

/// The corners of every cell of the bricks in which something was seen, 16 bytes a cell: one load
/// fetches them. Shared by all that look at the volume; a brick that is there stays.
struct NodePool {
  CellNode* nodes;          ///< 64 a slot, x fastest
  std::int32_t* first_of;   ///< a BrickArray of TextureVolume::Brick::first
  std::uint32_t* counters;  ///< slots asked for so far; bricks in `missing`
  std::int32_t* missing;    ///< indices without a rim; room for all bricks
  std::uint32_t capacity;   ///< slots
};

/// Which bricks are empty, from ExactTables::clear_until: level 0 of `levels` (8 octants of a byte
/// a brick, without a rim; bit i: the cube of 2^i bricks in the octant's direction is empty). Notes
/// the others that have no slot, and counts them all in `occupied`.
cudaError_t mark_bricks(const ValueRange* ranges, Int3 bricks, const std::int32_t* clear_until,
                        std::int32_t first_value, std::uint8_t* levels, const NodePool& pool,
                        std::uint32_t* occupied, cudaStream_t stream);
/// The arrays of ExactView::skips from level 0: the largest empty cubes, up to 127 bricks.
cudaError_t find_skips(std::uint8_t* levels, Int3 bricks, std::uint8_t* skips, cudaStream_t stream);
/// Fills the slots of the bricks noted as missing, as far as the pool goes.
cudaError_t fill_nodes(const TextureVolume& volume, Int3 bricks, const NodePool& pool,
                       cudaStream_t stream);

}  // namespace diaphane::render::cuda
