#pragma once

#include "renderd/engine/cuda/exact_types.h"
#include "renderd/engine/cuda/texture_volume.cuh"
#include "renderd/engine/cuda/warp_reduce.cuh"
#include "renderd/kernel/exact_estimator.h"

// Kernel 1 of the exact walk, which walks camera rays, with one thread per item. It is compiled by
// nvcc (ahead of time) and by NVRTC.

namespace diaphane::render::cuda {

#if !defined(DIAPHANE_CAMERA_BLOCKS)
#define DIAPHANE_CAMERA_BLOCKS 12
#endif
inline constexpr int kCameraBlock = 64;  ///< threads

/// Returns the number of strata of the kinds before `kind`.
HOST_DEVICE std::int32_t strata_before(const ExactView& exact, int kind) {
  std::int32_t sum = 0;
  for (int k = 0; k < kind; ++k) sum += exact.strata[k];
  return sum;
}

/// Holds the hits of a warp in shared memory until their number is known. They are indexed by the
/// stratum over all kinds and by the lane, so that no two lanes access the same bank.
struct StagedHits {
  float* memory;
  std::int32_t strata;
  std::uint32_t lane;

  static constexpr int kFields = 3;
  HOST_DEVICE static std::uint32_t bytes(std::int32_t strata) {
    return 4 * kTilePixels * kFields * static_cast<std::uint32_t>(strata);
  }
  __device__ __forceinline__ float& at(int field, std::int32_t stratum) const {
    return memory[(field * strata + stratum) * static_cast<std::int32_t>(kTilePixels) +
                  static_cast<std::int32_t>(lane)];
  }
};

/// Copies a tile's hits of the kinds from `first` up to `end`, exclusive, contiguously to `hits`.
/// The order is by stratum and, within a stratum, by lane. gather_kernel relies on this order.
/// `slot` is the item's first HitRecord::slot.
__device__ __forceinline__ void copy_hits(const ExactView& exact, const StagedHits& staged,
                                          const ExactItem& item, int first, int end,
                                          std::uint32_t slot, HitRecord* hits) {
  std::uint32_t next = 0;
  for (int kind = first; kind < end; ++kind) {
    const std::int32_t before = strata_before(exact, kind), mine = item.hits_of(kind);
    for (std::int32_t s = 0; s < exact.strata[kind]; ++s) {
      const std::uint32_t which = __ballot_sync(~0u, s < mine);
      if (which == 0) break;  // later strata have no hits either
      if (s < mine) {
        const std::int32_t stratum = before + s;
        hits[next + __popc(which & ((1u << staged.lane) - 1u))] = {
            staged.at(0, stratum), staged.at(1, stratum), staged.at(2, stratum),
            slot + static_cast<std::uint32_t>(stratum)};
      }
      next += static_cast<std::uint32_t>(__popc(which));
    }
  }
}

/// Returns the number of hits of the kinds from `first` up to `end`, exclusive, of all lanes.
__device__ __forceinline__ std::uint32_t hits_in_tile(const ExactItem& item, int first, int end) {
  std::int32_t mine = 0;
  for (int kind = first; kind < end; ++kind) mine += item.hits_of(kind);
  return warp_sum(static_cast<std::uint32_t>(mine));
}

template <std::uint32_t Bits>
__global__ void __launch_bounds__(kCameraBlock, DIAPHANE_CAMERA_BLOCKS)
    camera_kernel(const __grid_constant__ SceneView<TextureVolume> scene,
                  const __grid_constant__ Stripe stripe,
                  const __grid_constant__ ExactScratch scratch) {
  constexpr Features kF = Features{Bits};
  extern __shared__ float memory[];
  const std::uint32_t tile = (blockIdx.x * kCameraBlock + threadIdx.x) / kTilePixels,
                      lane = threadIdx.x % kTilePixels;
  const TileGrid tiles = tiles_of(scene.width, scene.height, stripe);
  if (tile >= tiles.per_sample() * stripe.samples) return;
  const ItemPlace place = place_of(tiles, stripe, tile, lane);
  const std::int32_t strata = strata_before(scene.exact, kHitKinds);
  const StagedHits staged{memory + threadIdx.x / kTilePixels * kTilePixels * StagedHits::kFields *
                                       static_cast<std::uint32_t>(strata),
                          strata, lane};

  ExactItem item{};
  if (place.x < scene.width && place.y < scene.height) {
    const CameraSample<kF, TextureVolume> camera(scene, place.x, place.y, place.sample);
    item.origin = camera.camera.ray.origin;
    item.direction = camera.camera.ray.direction;
    item.span = camera.primary.span;
    float transmittance = 1.0f;
    bool met = camera.primary.slice;
    if (camera.primary.span.begin < camera.primary.span.end) {
      // All targets are drawn at once, before the rays of the warp diverge.
      Random own = camera.random.fork(kCameraStream);
      constexpr KindList kKinds = hit_kinds<kF>();
      for (int k = 0; k < kKinds.count; ++k) {
        const int kind = kKinds.of[k];
        const std::int32_t count = scene.exact.strata[kind],
                           before = strata_before(scene.exact, kind);
        const float offset = stratum_offset(scene, camera, kind, own);
        for (std::int32_t i = 0; i < count; ++i) {
          staged.at(2, before + i) = target_depth(i, count, offset);
        }
      }
      const FirstWalk first = walk_camera_ray<kF>(
          scene, camera, [&](const HitNumber& hit) { return staged.at(2, hit.of_all); },
          own.exponential(),
          [&](const HitNumber& hit, const CellCrossing<TextureVolume>& cell, float depth) {
            staged.at(0, hit.of_all) = cell.segment.t0;
            staged.at(1, hit.of_all) = cell.segment.t1;
            staged.at(2, hit.of_all) = depth;
            item.hits += 1u << 6 * hit.kind;
          });
      transmittance = first.transmittance;
      met |= first.hit_medium;
    }
    item.radiance = camera.primary.background * transmittance;
    if (met) item.hits |= kItemMet;
    // A slice that adds less than half of 1/255 of white, in linear light, does not count as shown.
    if (camera.primary.slice && transmittance > 0.5f / 255.0f) item.hits |= kItemShowsSlice;
  }
  const std::uint32_t number = tile * kTilePixels + lane;
  scratch.items[number] = item;

  TileHits base{};
  const std::uint32_t light = hits_in_tile(item, 0, kIndirect),
                      indirect = hits_in_tile(item, kIndirect, kHitKinds);
  if (lane == 0) {
    if (light > 0) base.light = atomicAdd(scratch.counters + kLightHits, light);
    if (indirect > 0) {
      base.indirect = scratch.indirect + atomicAdd(scratch.counters + kIndirectHits, indirect);
    }
    scratch.tiles[tile] = base;
  }
  const std::uint32_t slot = number * kMostHits;
  if (light > 0) {
    const std::uint32_t first = __shfl_sync(~0u, base.light, 0);
    copy_hits(scene.exact, staged, item, 0, kIndirect, slot, scratch.hits + first);
  }
  if (indirect > 0) {
    const std::uint32_t first = __shfl_sync(~0u, base.indirect, 0);
    copy_hits(scene.exact, staged, item, kIndirect, kHitKinds, slot, scratch.hits + first);
  }
}

}  // namespace diaphane::render::cuda
