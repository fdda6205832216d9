#pragma once

#include <cuda_runtime_api.h>

#include <cstdint>

#include "renderd/film/film.h"
#include "renderd/film/guides.h"
#include "renderd/kernel/views.h"

// Types that the host and the trace kernels share. The C++ compiler, nvcc and NVRTC compile them.

namespace diaphane::render::cuda {

/// Voxel values at the corners of a cell, plus 32768, in the order of Corners. One load fetches all
/// 16 bytes.
struct alignas(16) CellNode {
  std::uint16_t corners[8];
};

/// The voxels in a 3D texture, where neighbours along all axes are near each other in memory. They
/// are fetched without filtering and interpolated in fp32, because the weights of the texture
/// unit's own filter have only 8 bits. The results equal those of LinearVolume.
struct TextureVolume {
  cudaTextureObject_t texture;  ///< int16, point sampling, element coordinates, clamped
  Int3 size;
  const CellNode* nodes;         ///< 64 per slot; cells of a brick, x fastest
  const std::int32_t* first_of;  ///< Brick::first, like ExactView::skips; points at brick (0, 0, 0)

  /// A brick of the exact walk. `first` is the index in `nodes` that cell (0, 0, 0) would have if
  /// the slot of the brick extended to that cell.
  struct Brick {
    std::int32_t first;  ///< kNoNodes if the brick has no slot
  };
  static constexpr std::int32_t kNoNodes = -0x7fffffff - 1;

#if defined(__CUDACC__)
  __device__ float at(Float3 index) const;
  __device__ ValueSpan corner_range(Int3 cell) const;
  __device__ Brick brick(std::int32_t index) const { return {first_of[index]}; }
  __device__ Corners corners(Int3 cell, Brick brick) const;
  __device__ CornerRange corner_values(Int3 cell, Brick brick) const;

 private:
  __device__ int4 packed(Int3 cell, Brick brick) const;
#endif
};

/// A stripe of rows, which is a part of one batch of samples.
struct Stripe {
  std::uint32_t first_row;    ///< a multiple of kStripeRows
  std::uint32_t rows;         ///< rows to trace; the last ones may lie below the picture
  std::uint64_t film_sample;  ///< number since the film was cleared; its parity selects the half
  std::uint32_t samples;      ///< per pixel
  std::uint32_t lane_shift;   ///< 2^lane_shift threads share a pixel's samples
};
inline constexpr std::uint32_t kStripeRows = 8;
inline constexpr std::uint32_t kMostLaneShift = 5;  ///< all threads of a warp
inline constexpr std::uint32_t kTraceBlock = 128;   ///< threads per block

/// The memory to which a trace kernel adds its results.
struct TraceTarget {
  FilmView film;
  std::uint64_t* dropped;          ///< number of samples that were not finite
  PackedGuides* guides = nullptr;  ///< means, written by kernels with Feature::kGuides; may be null
};

/// The part of the picture that a block covers: 2^(7 - lane_shift) pixels.
struct BlockTile {
  std::uint32_t width, height;
};
HOST_DEVICE BlockTile block_tile(std::uint32_t lane_shift) {
  const std::uint32_t bits = 7 - lane_shift;
  return {1u << (bits + 1) / 2, 1u << bits / 2};
}

}  // namespace diaphane::render::cuda
