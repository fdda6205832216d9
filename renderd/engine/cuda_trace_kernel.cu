#include <utility>

#include "renderd/engine/cuda_kernels.h"
#include "renderd/kernel/estimator.h"
#include "renderd/kernel/variants.h"

namespace diaphane::render::cuda {

__device__ __forceinline__ float TextureVolume::at(Float3 p) const {
  // As LinearVolume::at; the texture clamps the upper neighbour.
  const float fx = smaller(larger(p.x - 0.5f, 0.0f), static_cast<float>(size.x - 1));
  const float fy = smaller(larger(p.y - 0.5f, 0.0f), static_cast<float>(size.y - 1));
  const float fz = smaller(larger(p.z - 0.5f, 0.0f), static_cast<float>(size.z - 1));
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
    // The texture clamps the index -1 below the first voxel too.
    const float v =
        static_cast<float>(tex3D<short>(texture, static_cast<float>(cell.x - (corner & 1)),
                                        static_cast<float>(cell.y - (corner >> 1 & 1)),
                                        static_cast<float>(cell.z - (corner >> 2))));
    range.low = smaller(range.low, v);
    range.high = larger(range.high, v);
  }
  return range;
}

namespace {

constexpr std::uint32_t kBlock = 128;
/// Blocks that fit on a multiprocessor: caps the registers at 64, which is worth 5% on an H200.
constexpr std::uint32_t kBlocks = 8;

/// Every second bit of `morton`, from the lowest on: neighbours in Morton order are neighbours in
/// the picture, so the rays of a warp stay together.
__device__ std::uint32_t compact_bits(std::uint32_t morton) {
  morton &= 0x55u;
  morton = (morton | morton >> 1) & 0x33u;
  return (morton | morton >> 2) & 0x0fu;
}

/// The part of the block in the picture: 2^(7 - lane_shift) pixels.
struct BlockTile {
  std::uint32_t width, height;
};
__host__ __device__ BlockTile block_tile(std::uint32_t lane_shift) {
  const std::uint32_t bits = 7 - lane_shift;
  return {1u << (bits + 1) / 2, 1u << bits / 2};
}

/// Sums over the threads that share a pixel, in an order that does not depend on timing.
__device__ void join_lanes(PixelBatch& batch, std::uint32_t lanes) {
  for (std::uint32_t offset = 1; offset < lanes; offset <<= 1) {
    const auto other = [offset](auto value) { return __shfl_xor_sync(~0u, value, offset); };
    batch.even += Float3{other(batch.even.x), other(batch.even.y), other(batch.even.z)};
    batch.odd += Float3{other(batch.odd.x), other(batch.odd.y), other(batch.odd.z)};
    batch.dropped_even += other(batch.dropped_even);
    batch.dropped_odd += other(batch.dropped_odd);
    batch.met_matter |= other(static_cast<std::uint32_t>(batch.met_matter)) != 0;
  }
}

/// `Bits` are those of Features: nvcc cannot name a kernel by an argument of class type.
template <std::uint32_t Bits>
__global__ void __launch_bounds__(kBlock, kBlocks)
    trace_kernel(const __grid_constant__ SceneView<TextureVolume> scene,
                 const __grid_constant__ Stripe stripe, PixelBatch* batch_of) {
  const std::uint32_t lanes = 1u << stripe.lane_shift;
  const std::uint32_t lane = threadIdx.x & (lanes - 1);
  const std::uint32_t morton = threadIdx.x >> stripe.lane_shift;
  const BlockTile tile = block_tile(stripe.lane_shift);
  const std::uint32_t x = blockIdx.x * tile.width + compact_bits(morton);
  const std::uint32_t y = stripe.first_row + blockIdx.y * tile.height + compact_bits(morton >> 1);
  const bool inside = x < scene.width && y < scene.height;

  PixelBatch batch;
  if (inside) {
    for (std::uint32_t s = lane; s < stripe.samples; s += lanes) {
      const Sample sample = estimate<Features{Bits}>(scene, x, y, stripe.film_sample + s);
      batch.add(sample.radiance, sample.met_matter, stripe.film_sample + s);
    }
  }
  join_lanes(batch, lanes);  // by whole warps: threads outside the picture take part
  if (inside && lane == 0) batch_of[x + std::uint64_t{scene.width} * y] = batch;
}

using TraceKernel = void (*)(SceneView<TextureVolume>, Stripe, PixelBatch*);

template <std::size_t... I>
TraceKernel variant(std::size_t index, std::index_sequence<I...>) {
  static const TraceKernel table[] = {&trace_kernel<kVariants[I].bits>...};
  return table[index];
}
TraceKernel variant(Features needed) {
  return variant(variant_for(needed), std::make_index_sequence<kVariantCount>{});
}

}  // namespace

cudaError_t trace(Features features, const SceneView<TextureVolume>& scene, const Stripe& stripe,
                  PixelBatch* batch, cudaStream_t stream) {
  const BlockTile tile = block_tile(stripe.lane_shift);
  const std::uint32_t rows = smaller(stripe.rows, scene.height - stripe.first_row);
  const dim3 grid((scene.width + tile.width - 1) / tile.width,
                  (rows + tile.height - 1) / tile.height);
  variant(features)<<<grid, kBlock, 0, stream>>>(scene, stripe, batch);
  return cudaGetLastError();
}

cudaError_t probe() {
  cudaFuncAttributes attributes{};
  return cudaFuncGetAttributes(&attributes, reinterpret_cast<const void*>(variant(kAllFeatures)));
}

}  // namespace diaphane::render::cuda
