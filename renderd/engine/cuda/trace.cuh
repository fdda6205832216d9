#pragma once

#include "renderd/engine/cuda/texture_volume.cuh"
#include "renderd/engine/cuda/trace_types.h"
#include "renderd/kernel/estimator.h"

// The trace kernel, compiled by nvcc (ahead of time) and by NVRTC (for the features of a scene).

namespace diaphane::render::cuda {

/// Number of blocks that must fit on a multiprocessor. This limits the registers of a thread to 64,
/// which is 5% faster on an H200.
inline constexpr std::uint32_t kTraceBlocks = 8;

/// Returns every second bit of `morton`, beginning with the lowest. Neighbours in Morton order are
/// neighbours in the picture, so the rays of a warp stay together.
__device__ __forceinline__ std::uint32_t compact_bits(std::uint32_t morton) {
  morton &= 0x55u;
  morton = (morton | morton >> 1) & 0x33u;
  return (morton | morton >> 2) & 0x0fu;
}

/// Sums `batch` over the threads that share a pixel, in an order that does not depend on timing.
__device__ __forceinline__ void join_lanes(PixelBatch& batch, std::uint32_t lanes) {
  for (std::uint32_t offset = 1; offset < lanes; offset <<= 1) {
    const auto other = [offset](auto value) { return __shfl_xor_sync(~0u, value, offset); };
    batch.even += Float3{other(batch.even.x), other(batch.even.y), other(batch.even.z)};
    batch.odd += Float3{other(batch.odd.x), other(batch.odd.y), other(batch.odd.z)};
    batch.dropped_even += other(batch.dropped_even);
    batch.dropped_odd += other(batch.dropped_odd);
    batch.hit_medium |= other(static_cast<std::uint32_t>(batch.hit_medium)) != 0;
    batch.hit_slice |= other(static_cast<std::uint32_t>(batch.hit_slice)) != 0;
  }
}

__device__ __forceinline__ void join_lanes(Guides& guides, std::uint32_t lanes) {
  for (std::uint32_t offset = 1; offset < lanes; offset <<= 1) {
    const auto other = [offset](float value) { return __shfl_xor_sync(~0u, value, offset); };
    guides += Guides{other(guides.opacity),
                     other(guides.depth),
                     {other(guides.albedo.x), other(guides.albedo.y), other(guides.albedo.z)},
                     {other(guides.normal.x), other(guides.normal.y), other(guides.normal.z)}};
  }
}

/// Adds the guides of a launch's samples to those of the film. Call it from one thread per pixel.
__device__ __forceinline__ void add_guides(const TraceTarget& target, std::uint64_t pixel,
                                           const Stripe& stripe, const Guides& sum) {
  if (target.guides == nullptr || stripe.film_sample >= kGuidedSamples) return;
  const auto before = static_cast<std::uint32_t>(stripe.film_sample);
  const std::uint32_t left = static_cast<std::uint32_t>(kGuidedSamples) - before;
  target.guides[pixel] = with_samples(target.guides[pixel], before, sum, min(left, stripe.samples));
}

/// Adds a pixel's batch to the film. Call it from one thread per pixel.
__device__ __forceinline__ void add_batch(const TraceTarget& target, std::uint64_t pixel,
                                          const PixelBatch& batch) {
  fold(target.film, pixel, batch);
  if (const std::uint32_t count = batch.dropped_even + batch.dropped_odd; count != 0) {
    // atomicAdd() is not defined for std::uint64_t, which is another type of the same size.
    atomicAdd(reinterpret_cast<unsigned long long*>(target.dropped),
              static_cast<unsigned long long>(count));
  }
}

/// Traces the samples of a stripe. `Bits` is Features::bits, because nvcc cannot name a kernel
/// whose template argument has a class type. The threads of a pixel sum the samples of a launch in
/// fp32 and add the sum to the film at the end, without a buffer in between.
template <std::uint32_t Bits>
__global__ void __launch_bounds__(kTraceBlock, kTraceBlocks)
    trace_kernel(const __grid_constant__ SceneView<TextureVolume> scene,
                 const __grid_constant__ Stripe stripe,
                 const __grid_constant__ TraceTarget target) {
  const std::uint32_t lanes = 1u << stripe.lane_shift;
  const std::uint32_t lane = threadIdx.x & (lanes - 1);
  const std::uint32_t morton = threadIdx.x >> stripe.lane_shift;
  const BlockTile tile = block_tile(stripe.lane_shift);
  const std::uint32_t x = blockIdx.x * tile.width + compact_bits(morton);
  const std::uint32_t y = stripe.first_row + blockIdx.y * tile.height + compact_bits(morton >> 1);
  const bool inside = x < scene.width && y < scene.height;

  constexpr bool kGuided = Features{Bits}.has(Feature::kGuides);
  PixelBatch batch;
  [[maybe_unused]] Guides guides{};
  if (inside) {
    for (std::uint32_t s = lane; s < stripe.samples; s += lanes) {
      const auto sample = estimate<Features{Bits}>(scene, x, y, stripe.film_sample + s);
      if constexpr (kGuided) guides += sample.guides;
      batch.add(sample.radiance, sample.hit_medium, stripe.film_sample + s, sample.shows_slice);
    }
  }
  // Whole warps participate, including threads outside the picture.
  join_lanes(batch, lanes);
  if constexpr (kGuided) join_lanes(guides, lanes);
  if (inside && lane == 0) {
    const std::uint64_t pixel = x + std::uint64_t{scene.width} * y;
    add_batch(target, pixel, batch);
    if constexpr (kGuided) add_guides(target, pixel, stripe, guides);
  }
}

}  // namespace diaphane::render::cuda
