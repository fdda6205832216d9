#pragma once

#include "renderd/engine/cuda/trace_types.h"
#include "renderd/kernel/exact_walk.h"

// The functions with which kernels read the texture of voxels.

namespace diaphane::render::cuda {

__device__ __forceinline__ float TextureVolume::at(Float3 p) const {
  // Works like LinearVolume::at; the texture clamps the upper neighbour.
  const float fx = min(max(p.x - 0.5f, 0.0f), static_cast<float>(size.x - 1));
  const float fy = min(max(p.y - 0.5f, 0.0f), static_cast<float>(size.y - 1));
  const float fz = min(max(p.z - 0.5f, 0.0f), static_cast<float>(size.z - 1));
  const float x = floorf(fx), y = floorf(fy), z = floorf(fz);
  const float wx = fx - x, wy = fy - y, wz = fz - z;
  const auto fetch = [this](float i, float j, float k) {
    return static_cast<float>(tex3D<short>(texture, i, j, k));
  };
  const float v000 = fetch(x, y, z), v100 = fetch(x + 1, y, z);
  const float v010 = fetch(x, y + 1, z), v110 = fetch(x + 1, y + 1, z);
  const float v001 = fetch(x, y, z + 1), v101 = fetch(x + 1, y, z + 1);
  const float v011 = fetch(x, y + 1, z + 1), v111 = fetch(x + 1, y + 1, z + 1);
  const float v00 = v000 + wx * (v100 - v000), v10 = v010 + wx * (v110 - v010);
  const float v01 = v001 + wx * (v101 - v001), v11 = v011 + wx * (v111 - v011);
  const float v0 = v00 + wy * (v10 - v00), v1 = v01 + wy * (v11 - v01);
  return v0 + wz * (v1 - v0);
}

__device__ __forceinline__ ValueSpan TextureVolume::corner_range(Int3 cell) const {
  ValueSpan range{32767.0f, -32768.0f};
  for (int corner = 0; corner < 8; ++corner) {
    // The texture also clamps the index -1 below the first voxel.
    const float v =
        static_cast<float>(tex3D<short>(texture, static_cast<float>(cell.x - (corner & 1)),
                                        static_cast<float>(cell.y - (corner >> 1 & 1)),
                                        static_cast<float>(cell.z - (corner >> 2))));
    range.low = min(range.low, v);
    range.high = max(range.high, v);
  }
  return range;
}

/// Returns the corner values of a cell without a node, packed as in a CellNode.
__device__ __forceinline__ int4 packed_from_texture(cudaTextureObject_t texture, Int3 cell) {
  unsigned pairs[4];
  for (int row = 0; row < 4; ++row) {
    const float y = static_cast<float>(cell.y - 1 + (row & 1)),
                z = static_cast<float>(cell.z - 1 + (row >> 1));
    const float x = static_cast<float>(cell.x);
    const int low = tex3D<short>(texture, x - 1, y, z), high = tex3D<short>(texture, x, y, z);
    pairs[row] = static_cast<unsigned>(low + 32768) | static_cast<unsigned>(high + 32768) << 16;
  }
  return {static_cast<int>(pairs[0]), static_cast<int>(pairs[1]), static_cast<int>(pairs[2]),
          static_cast<int>(pairs[3])};
}

__device__ __forceinline__ int4 TextureVolume::packed(Int3 cell, Brick brick) const {
  if (brick.first == kNoNodes) return packed_from_texture(texture, cell);
  const std::int32_t node =
      brick.first + cell.x + kBrickSize * cell.y + kBrickSize * kBrickSize * cell.z;
  return __ldg(reinterpret_cast<const int4*>(nodes) + node);
}

__device__ __forceinline__ Corners TextureVolume::corners(Int3 cell, Brick brick) const {
  const int4 four = packed(cell, brick);
  // The lowest bits of the float 2^23 + n are n, so a byte permutation and a subtraction convert a
  // 16-bit number to a float. A conversion instruction runs at only an eighth of their rate.
  const auto number = [](int two, unsigned bytes) {
    return __uint_as_float(__byte_perm(static_cast<unsigned>(two), 0x4b000000u, bytes)) -
           (8388608.0f + 32768.0f);
  };
  constexpr unsigned kLow = 0x7610, kHigh = 0x7632;
  return {{number(four.x, kLow), number(four.x, kHigh), number(four.y, kLow), number(four.y, kHigh),
           number(four.z, kLow), number(four.z, kHigh), number(four.w, kLow),
           number(four.w, kHigh)}};
}

__device__ __forceinline__ CornerRange TextureVolume::corner_values(Int3 cell, Brick brick) const {
  const int4 four = packed(cell, brick);
  const auto x = static_cast<unsigned>(four.x), y = static_cast<unsigned>(four.y),
             z = static_cast<unsigned>(four.z), w = static_cast<unsigned>(four.w);
  const unsigned low = __vminu2(__vminu2(x, y), __vminu2(z, w));
  const unsigned high = __vmaxu2(__vmaxu2(x, y), __vmaxu2(z, w));
  return {static_cast<std::int32_t>(min(low & 0xffffu, low >> 16)) - 32768,
          static_cast<std::int32_t>(max(high & 0xffffu, high >> 16)) - 32768};
}

}  // namespace diaphane::render::cuda
