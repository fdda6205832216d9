#include "renderd/engine/cuda/exact_kernels.h"
#include "renderd/engine/cuda/warp_reduce.cuh"

namespace diaphane::render::cuda {
namespace {

constexpr std::uint32_t kBlock = 256;
constexpr std::uint32_t kWarp = 32;
constexpr int kLevels = 7;  // cubes of 1 to 64 bricks

std::uint32_t blocks_for(std::uint64_t count) {
  return static_cast<std::uint32_t>((count + kBlock - 1) / kBlock);
}
__device__ std::int32_t thread_index() {
  return static_cast<std::int32_t>(blockIdx.x * blockDim.x + threadIdx.x);
}
__device__ Int3 coordinates(std::int32_t i, Int3 size) {
  return {i % size.x, i / size.x % size.y, i / size.x / size.y};
}
std::int32_t count_of(Int3 bricks) { return bricks.x * bricks.y * bricks.z; }

/// Computes the range of brick b, one per warp, from the voxels 4b - 1 to 4b + 3 along each axis.
__global__ void range_kernel(TextureVolume volume, Int3 bricks, std::int32_t count,
                             ValueRange* ranges) {
  const std::int32_t brick = thread_index() / static_cast<std::int32_t>(kWarp);
  if (brick >= count) return;
  const Int3 b = coordinates(brick, bricks);
  std::int32_t low = 32767, high = -32768;
  for (std::int32_t i = static_cast<std::int32_t>(threadIdx.x % kWarp); i < 125; i += kWarp) {
    // The texture clamps indices outside the volume to voxels that also belong to the brick.
    const std::int32_t value =
        tex3D<short>(volume.texture, static_cast<float>(b.x * kBrickSize - 1 + i % 5),
                     static_cast<float>(b.y * kBrickSize - 1 + i / 5 % 5),
                     static_cast<float>(b.z * kBrickSize - 1 + i / 25));
    low = min(low, value);
    high = max(high, value);
  }
  low = warp_min(low);
  high = warp_max(high);
  if (threadIdx.x % kWarp == 0)
    ranges[brick] = {static_cast<std::int16_t>(low), static_cast<std::int16_t>(high)};
}

__global__ void mark_kernel(const ValueRange* ranges, Int3 bricks, std::int32_t count,
                            const std::int32_t* clear_until, std::int32_t first_value,
                            std::uint8_t* levels, NodePool pool, std::uint32_t* occupied) {
  const std::int32_t brick = thread_index();
  if (brick >= count) return;
  const std::int32_t index = BrickArray(bricks).index(coordinates(brick, bricks));
  const ValueRange range = ranges[brick];
  const bool empty = range.maximum <= clear_until[range.minimum - first_value];
  for (int octant = 0; octant < 8; ++octant)
    levels[std::int64_t{octant} * count + brick] = empty ? 1 : 0;
  if (empty) return;
  atomicAdd(occupied, 1u);
  if (pool.capacity > 0 && pool.first_of[index] == TextureVolume::kNoNodes)
    pool.missing[atomicAdd(&pool.counters[1], 1u)] = brick;
}

struct Octant {
  Int3 towards;

  __device__ explicit Octant(int octant)
      : towards{(octant & 1) != 0 ? 1 : -1, (octant & 2) != 0 ? 1 : -1,
                (octant & 4) != 0 ? 1 : -1} {}
  /// Returns whether the cube of 2^level bricks that begins at `b` is empty. Everything outside the
  /// volume counts as empty.
  __device__ bool empty(const std::uint8_t* levels, Int3 bricks, Int3 b, int level) const {
    if (b.x < 0 || b.y < 0 || b.z < 0 || b.x >= bricks.x || b.y >= bricks.y || b.z >= bricks.z)
      return true;
    return (levels[b.x + bricks.x * (b.y + bricks.y * b.z)] >> level & 1) != 0;
  }
  /// Returns whether the cube of 2^level + offset bricks is empty, for an offset of at most
  /// 2^level. Eight overlapping cubes of 2^level bricks cover it.
  __device__ bool covered(const std::uint8_t* levels, Int3 bricks, Int3 b, int level,
                          std::int32_t offset) const {
    for (int corner = 0; corner < 8; ++corner) {
      const Int3 at{b.x + ((corner & 1) != 0 ? offset : 0) * towards.x,
                    b.y + ((corner & 2) != 0 ? offset : 0) * towards.y,
                    b.z + ((corner & 4) != 0 ? offset : 0) * towards.z};
      if (!empty(levels, bricks, at, level)) return false;
    }
    return true;
  }
};

/// Computes level `level` from the previous level. Another thread may read the byte while it is
/// written, but uses only the bits of lower levels.
__global__ void level_kernel(std::uint8_t* levels, Int3 bricks, std::int32_t count, int level) {
  const std::int32_t brick = thread_index();
  if (brick >= count) return;
  std::uint8_t* mine = levels + std::int64_t{blockIdx.y} * count;
  const Octant octant(static_cast<int>(blockIdx.y));
  if ((mine[brick] >> (level - 1) & 1) == 0) return;
  if (octant.covered(mine, bricks, coordinates(brick, bricks), level - 1, 1 << (level - 1))) {
    mine[brick] = static_cast<std::uint8_t>(mine[brick] | 1 << level);
  }
}

__global__ void skip_kernel(const std::uint8_t* levels, Int3 bricks, std::int32_t count,
                            std::uint8_t* skips) {
  const std::int32_t brick = thread_index();
  if (brick >= count) return;
  const std::uint8_t* mine = levels + std::int64_t{blockIdx.y} * count;
  const Octant octant(static_cast<int>(blockIdx.y));
  std::int32_t skip = 0;
  if (mine[brick] != 0) {
    const int level = 31 - __clz(mine[brick]);
    const Int3 b = coordinates(brick, bricks);
    std::int32_t offset = 0;
    for (std::int32_t step = 1 << level >> 1; step > 0; step >>= 1) {
      if (octant.covered(mine, bricks, b, level, offset + step)) offset += step;
    }
    skip = (1 << level) + offset;
  }
  const BrickArray array(bricks);
  skips[std::int64_t{blockIdx.y} * array.count + array.index(coordinates(brick, bricks))] =
      static_cast<std::uint8_t>(skip);
}

/// Fills the slots of missing bricks, one brick per block at a time, with one thread per cell.
__global__ void node_kernel(TextureVolume volume, Int3 bricks, NodePool pool) {
  const std::uint32_t missing = pool.counters[1];
  for (std::uint32_t i = blockIdx.x; i < missing; i += gridDim.x) {
    const std::uint32_t slot = pool.counters[0] + i;
    if (slot >= pool.capacity) return;
    const std::int32_t brick = pool.missing[i];
    const Int3 b = coordinates(brick, bricks);
    const std::int32_t cell = static_cast<std::int32_t>(threadIdx.x);
    const Int3 c{b.x * kBrickSize + (cell & 3), b.y * kBrickSize + (cell >> 2 & 3),
                 b.z * kBrickSize + (cell >> 4)};
    CellNode node;
    for (int corner = 0; corner < 8; ++corner) {
      // The texture clamps indices outside the volume.
      node.corners[corner] = static_cast<std::uint16_t>(
          32768 + tex3D<short>(volume.texture, static_cast<float>(c.x - 1 + (corner & 1)),
                               static_cast<float>(c.y - 1 + (corner >> 1 & 1)),
                               static_cast<float>(c.z - 1 + (corner >> 2))));
    }
    pool.nodes[std::int64_t{slot} * 64 + cell] = node;
    // A kernel of another session may run now, so the slot is published only after it is filled.
    __threadfence();
    __syncthreads();
    if (threadIdx.x == 0) {
      pool.first_of[BrickArray(bricks).index(b)] =
          static_cast<std::int32_t>(slot << 3 * kBrickShift) -
          kBrickSize * (b.x + kBrickSize * (b.y + kBrickSize * b.z));
    }
  }
}

__global__ void taken_kernel(NodePool pool) {
  pool.counters[0] = min(pool.counters[0] + pool.counters[1], pool.capacity);
  pool.counters[1] = 0;
}

}  // namespace

cudaError_t brick_ranges(const TextureVolume& volume, Int3 bricks, ValueRange* ranges,
                         cudaStream_t stream) {
  const std::int32_t count = count_of(bricks);
  range_kernel<<<blocks_for(std::uint64_t{kWarp} * static_cast<std::uint64_t>(count)), kBlock, 0,
                 stream>>>(volume, bricks, count, ranges);
  return cudaGetLastError();
}

cudaError_t mark_bricks(const ValueRange* ranges, Int3 bricks, const std::int32_t* clear_until,
                        std::int32_t first_value, std::uint8_t* levels, const NodePool& pool,
                        std::uint32_t* occupied, cudaStream_t stream) {
  const std::int32_t count = count_of(bricks);
  mark_kernel<<<blocks_for(static_cast<std::uint64_t>(count)), kBlock, 0, stream>>>(
      ranges, bricks, count, clear_until, first_value, levels, pool, occupied);
  return cudaGetLastError();
}

cudaError_t find_skips(std::uint8_t* levels, Int3 bricks, std::uint8_t* skips,
                       cudaStream_t stream) {
  const std::int32_t count = count_of(bricks);
  const dim3 grid(blocks_for(static_cast<std::uint64_t>(count)), 8);
  const auto bytes = 8 * static_cast<std::size_t>(BrickArray(bricks).count);
  if (const cudaError_t status = cudaMemsetAsync(skips, kOutside, bytes, stream);
      status != cudaSuccess) {
    return status;
  }
  for (int level = 1; level < kLevels; ++level)
    level_kernel<<<grid, kBlock, 0, stream>>>(levels, bricks, count, level);
  skip_kernel<<<grid, kBlock, 0, stream>>>(levels, bricks, count, skips);
  return cudaGetLastError();
}

cudaError_t fill_nodes(const TextureVolume& volume, Int3 bricks, const NodePool& pool,
                       cudaStream_t stream) {
  // This is 32 blocks for each multiprocessor of an H100 or H200.
  constexpr std::uint32_t kBlocks = 132 * 32;
  node_kernel<<<kBlocks, 64, 0, stream>>>(volume, bricks, pool);
  taken_kernel<<<1, 1, 0, stream>>>(pool);
  return cudaGetLastError();
}

}  // namespace diaphane::render::cuda
