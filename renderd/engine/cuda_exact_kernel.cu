#include <utility>

#include "renderd/engine/cuda_exact.cuh"
#include "renderd/engine/cuda_exact.h"
#include "renderd/kernel/variants.h"

namespace diaphane::render::cuda {
namespace {

template <std::size_t... I>
const void* entry_of(std::size_t index, std::index_sequence<I...>) {
  static const void* const table[] = {
      reinterpret_cast<const void*>(&exact_kernel<kVariants[I].bits>)...};
  return table[index];
}

KernelTemplate::Instance ahead_of_time(Features needed) {
  const std::size_t index = variant_for(needed);
  return {entry_of(index, std::make_index_sequence<kVariantCount>{}), kVariants[index]};
}

}  // namespace

const KernelTemplate kExactKernel{.name = "exact walk",
                                  .header = "renderd/engine/cuda_exact.cuh",
                                  .expression = "diaphane::render::cuda::exact_kernel",
                                  .ahead_of_time = &ahead_of_time};

cudaError_t trace_exact(const Variant& variant, const SceneView<TextureVolume>& scene,
                        const Stripe& stripe, const TraceTarget& target, cudaStream_t stream) {
  const std::uint32_t rows = smaller(stripe.rows, scene.height - stripe.first_row);
  const dim3 grid((scene.width + 7) / 8, (rows + 3) / 4);
  const auto strata = static_cast<std::uint32_t>(begin_of(scene.exact, kHitKinds));
  const std::size_t shared = exact_shared_bytes(variant.features, strata);
  // CUDA's one signature for all kernels takes pointers to arguments that are not const.
  void* arguments[] = {const_cast<SceneView<TextureVolume>*>(&scene), const_cast<Stripe*>(&stripe),
                       const_cast<TraceTarget*>(&target)};
  return cudaLaunchKernel(variant.entry, grid, dim3(kTraceBlock), arguments, shared, stream);
}

}  // namespace diaphane::render::cuda
