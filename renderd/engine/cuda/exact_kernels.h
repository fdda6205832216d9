#pragma once

#include <cuda_runtime_api.h>

#include "renderd/engine/cuda/trace_types.h"
#include "renderd/scene/grid.h"

// Kernels that prepare the voxels and the transfer function for the exact walk. Each function
// queues its kernels on a stream and returns the status of the launch.

namespace diaphane::render::cuda {

/// Returns the number of bricks along each axis for a volume of `size` voxels (ValueGrid::bricks).
constexpr Int3 bricks_of(Int3 size) {
  return {(size.x >> kBrickShift) + 1, (size.y >> kBrickShift) + 1, (size.z >> kBrickShift) + 1};
}

/// Computes the range of the values at the corners of the cells of each brick, equal to
/// ValueGrid::brick_ranges.
cudaError_t brick_ranges(const TextureVolume& volume, Int3 bricks, ValueRange* ranges,
                         cudaStream_t stream);

/// The values at the corners of every cell of the bricks that contained matter in any scene. One
/// load fetches the 16 bytes of a cell. All sessions of the volume share the pool, and a brick is
/// never removed.
struct NodePool {
  CellNode* nodes;          ///< 64 per slot, x fastest
  std::int32_t* first_of;   ///< a BrickArray of TextureVolume::Brick::first
  std::uint32_t* counters;  ///< number of slots in use, and number of bricks in `missing`
  std::int32_t* missing;    ///< indices without a rim, with room for all bricks
  std::uint32_t capacity;   ///< number of slots
};

/// Marks empty bricks according to ExactTables::clear_until in level 0 of `levels`, which has one
/// byte per brick for each of 8 octants, without a rim. Bit i of a byte says that the cube of 2^i
/// bricks in the direction of the octant is empty. Adds the number of bricks that are not empty to
/// `occupied`, and lists those of them that have no slot in `missing`.
cudaError_t mark_bricks(const ValueRange* ranges, Int3 bricks, const std::int32_t* clear_until,
                        std::int32_t first_value, std::uint8_t* levels, const NodePool& pool,
                        std::uint32_t* occupied, cudaStream_t stream);
/// Computes the largest empty cubes (ExactView::skips), up to 127 bricks wide, from level 0.
cudaError_t find_skips(std::uint8_t* levels, Int3 bricks, std::uint8_t* skips, cudaStream_t stream);
/// Fills slots for the missing bricks until the pool is full.
cudaError_t fill_nodes(const TextureVolume& volume, Int3 bricks, const NodePool& pool,
                       cudaStream_t stream);

}  // namespace diaphane::render::cuda
