#include <utility>

#include "renderd/engine/cuda/trace.cuh"
#include "renderd/engine/cuda/trace.h"
#include "renderd/kernel/variants.h"

namespace diaphane::render::cuda {
namespace {

template <std::size_t... I>
const void* entry_of(std::size_t index, std::index_sequence<I...>) {
  static const void* const table[] = {
      reinterpret_cast<const void*>(&trace_kernel<kVariants[I].bits>)...};
  return table[index];
}

KernelTemplate::Instance ahead_of_time(Features needed) {
  const std::size_t index = variant_for(needed);
  return {entry_of(index, std::make_index_sequence<kVariantCount>{}), kVariants[index]};
}

}  // namespace

const KernelTemplate kTraceKernel{.name = "tracking",
                                  .header = "renderd/engine/cuda/trace.cuh",
                                  .expression = "diaphane::render::cuda::trace_kernel",
                                  .ahead_of_time = &ahead_of_time};

cudaError_t trace(const Variant& variant, const SceneView<TextureVolume>& scene,
                  const Stripe& stripe, const TraceTarget& target, cudaStream_t stream) {
  const BlockTile tile = block_tile(stripe.lane_shift);
  const std::uint32_t rows = min(stripe.rows, scene.height - stripe.first_row);
  const dim3 grid((scene.width + tile.width - 1) / tile.width,
                  (rows + tile.height - 1) / tile.height);
  // cudaLaunchKernel has one signature for all kernels, which takes pointers to non-const
  // arguments.
  void* arguments[] = {const_cast<SceneView<TextureVolume>*>(&scene), const_cast<Stripe*>(&stripe),
                       const_cast<TraceTarget*>(&target)};
  return cudaLaunchKernel(variant.entry, grid, dim3(kTraceBlock), arguments, 0, stream);
}

}  // namespace diaphane::render::cuda
