#include <algorithm>
#include <utility>

#include "renderd/engine/cuda/error.h"
#include "renderd/engine/cuda/exact.h"
#include "renderd/engine/cuda/exact_light.cuh"
#include "renderd/engine/cuda/trace.cuh"
#include "renderd/kernel/variants.h"

namespace diaphane::render::cuda {
namespace {

constexpr int kGatherBlock = 64;

/// Returns the light of one item: the sum over its hits, in the order in which copy_hits() stored
/// the hits. All lanes of the warp must call this function.
__device__ Float3 light_of(const ExactView& exact, const ExactItem& item, const TileHits& tile,
                           const ExactScratch& scratch, std::uint32_t lane) {
  Float3 sum = item.radiance;
  std::uint32_t next = tile.light;
  for (int kind = 0; kind < kHitKinds; ++kind) {
    if (kind == kIndirect) next = tile.indirect;
    const std::int32_t mine = item.hits_of(kind);
    for (std::int32_t s = 0; s < exact.strata[kind]; ++s) {
      const std::uint32_t which = __ballot_sync(~0u, s < mine);
      if (which == 0) break;
      if (s < mine) {
        const std::uint32_t index = next + __popc(which & ((1u << lane) - 1u));
        const HitRecord& hit = scratch.hits[index];
        sum += Float3{hit.a, hit.b, hit.c};
        if (scratch.glow != nullptr && kind != kIndirect) {
          const Float4 own = scratch.glow[index];
          sum += Float3{own.x, own.y, own.z};
        }
      }
      next += static_cast<std::uint32_t>(__popc(which));
    }
  }
  return sum;
}

/// Kernel 3 of the exact walk, which adds the items to the film, with one thread per pixel.
template <bool Guided>
__global__ void __launch_bounds__(kGatherBlock)
    gather_kernel(const __grid_constant__ SceneView<TextureVolume> scene,
                  const __grid_constant__ Stripe stripe,
                  const __grid_constant__ ExactScratch scratch,
                  const __grid_constant__ TraceTarget target) {
  const std::uint32_t tile = (blockIdx.x * kGatherBlock + threadIdx.x) / kTilePixels,
                      lane = threadIdx.x % kTilePixels;
  const TileGrid tiles = tiles_of(scene.width, scene.height, stripe);
  if (tile >= tiles.per_sample()) return;
  const ItemPlace place = place_of(tiles, stripe, tile, lane);
  const bool inside = place.x < scene.width && place.y < scene.height;
  PixelBatch batch;
  [[maybe_unused]] Guides guides{};
  for (std::uint32_t s = 0; s < stripe.samples; ++s) {
    const std::uint32_t t = tile + s * tiles.per_sample();
    const ExactItem item = scratch.items[t * kTilePixels + lane];
    const Float3 light = light_of(scene.exact, item, scratch.tiles[t], scratch, lane);
    if (!inside) continue;
    const std::uint64_t number = stripe.film_sample + s;
    batch.add(light, (item.hits & kItemMet) != 0, number, (item.hits & kItemShowsSlice) != 0);
    if constexpr (Guided) {
      if (number < kGuidedSamples)
        guides += guides_along(scene, Ray{item.origin, item.direction}, item.span);
    }
  }
  if (!inside) return;
  const std::uint64_t pixel = place.x + std::uint64_t{scene.width} * place.y;
  add_batch(target, pixel, batch);
  if constexpr (Guided) add_guides(target, pixel, stripe, guides);
}

// A kernel template cannot be a template argument, so each of the types below stands for a kernel
// and returns its instances.
struct Camera {
  template <std::uint32_t Bits>
  static const void* entry() {
    return reinterpret_cast<const void*>(&camera_kernel<Bits>);
  }
};
struct Light {
  template <std::uint32_t Bits>
  static const void* entry() {
    return reinterpret_cast<const void*>(&light_kernel<Bits>);
  }
};
struct Indirect {
  template <std::uint32_t Bits>
  static const void* entry() {
    return reinterpret_cast<const void*>(&indirect_kernel<Bits>);
  }
};

template <typename Kernel, std::size_t... I>
const void* entry_of(std::size_t index, std::index_sequence<I...>) {
  static const void* const table[] = {Kernel::template entry<kVariants[I].bits>()...};
  return table[index];
}

/// Returns the smallest suitable instance. Guides count only if all features are needed, because
/// the gather kernel alone records them.
template <typename Kernel>
KernelTemplate::Instance ahead_of_time(Features needed) {
  const std::size_t index =
      variant_for(needed == kAllFeatures ? needed : needed.without(Feature::kGuides));
  return {entry_of<Kernel>(index, std::make_index_sequence<kVariantCount>{}), kVariants[index]};
}

std::uint32_t blocks_for(std::uint64_t threads, std::uint32_t block) {
  return static_cast<std::uint32_t>((threads + block - 1) / block);
}

}  // namespace

const KernelTemplate kExactCamera{.name = "exact walk, camera rays",
                                  .header = "renderd/engine/cuda/exact_camera.cuh",
                                  .expression = "diaphane::render::cuda::camera_kernel",
                                  .ahead_of_time = &ahead_of_time<Camera>};
const KernelTemplate kExactLight{.name = "exact walk, rays to lights",
                                 .header = "renderd/engine/cuda/exact_light.cuh",
                                 .expression = "diaphane::render::cuda::light_kernel",
                                 .ahead_of_time = &ahead_of_time<Light>};
const KernelTemplate kExactIndirect{.name = "exact walk, indirect paths",
                                    .header = "renderd/engine/cuda/exact_light.cuh",
                                    .expression = "diaphane::render::cuda::indirect_kernel",
                                    .ahead_of_time = &ahead_of_time<Indirect>};

cudaError_t trace_exact(const ExactKernels& kernels, const SceneView<TextureVolume>& scene,
                        const Stripe& stripe, const ExactScratch& scratch,
                        const TraceTarget& target, std::uint32_t light_blocks,
                        cudaStream_t stream) {
  // cudaLaunchKernel has one signature for all kernels, which takes pointers to non-const
  // arguments.
  void* arguments[] = {const_cast<SceneView<TextureVolume>*>(&scene), const_cast<Stripe*>(&stripe),
                       const_cast<ExactScratch*>(&scratch), const_cast<TraceTarget*>(&target)};
  const TileGrid tiles = tiles_of(scene.width, scene.height, stripe);
  const std::uint64_t pixels = std::uint64_t{tiles.per_sample()} * kTilePixels;
  const std::int32_t strata = strata_before(scene.exact, kHitKinds);
  const std::uint32_t staged = kCameraBlock / kTilePixels * StagedHits::bytes(strata);
  cudaError_t status =
      cudaMemsetAsync(scratch.counters, 0, kExactCounters * sizeof(std::uint32_t), stream);
  if (status != cudaSuccess) return status;
  status = cudaLaunchKernel(kernels.camera->entry,
                            dim3(blocks_for(pixels * stripe.samples, kCameraBlock)),
                            dim3(kCameraBlock), arguments, staged, stream);
  if (status != cudaSuccess) return status;
  status = cudaLaunchKernel(kernels.light->entry, dim3(light_blocks), dim3(kLightBlock), arguments,
                            0, stream);
  if (status != cudaSuccess) return status;
  if (kernels.indirect != nullptr) {
    status = cudaLaunchKernel(kernels.indirect->entry, dim3(8 * light_blocks), dim3(kLightBlock),
                              arguments, 0, stream);
    if (status != cudaSuccess) return status;
  }
  const bool guided = target.guides != nullptr && stripe.film_sample < kGuidedSamples;
  const void* gather = guided ? reinterpret_cast<const void*>(&gather_kernel<true>)
                              : reinterpret_cast<const void*>(&gather_kernel<false>);
  return cudaLaunchKernel(gather, dim3(blocks_for(pixels, kGatherBlock)), dim3(kGatherBlock),
                          arguments, 0, stream);
}

Result<std::uint32_t> light_blocks(const Variant& light) {
  int device = 0, processors = 0, blocks = 0;
  DIAPHANE_CUDA_TRY(cudaGetDevice(&device));
  DIAPHANE_CUDA_TRY(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device));
  DIAPHANE_CUDA_TRY(
      cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, light.entry, kLightBlock, 0));
  return static_cast<std::uint32_t>(std::max(blocks, 1) * processors);
}

}  // namespace diaphane::render::cuda
