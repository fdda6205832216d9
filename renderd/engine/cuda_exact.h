#pragma once

#include "renderd/engine/cuda_nvrtc.h"
#include "renderd/engine/cuda_trace_types.h"
#include "renderd/engine/cuda_variants.h"

namespace diaphane::render::cuda {

/// The exact walk (cuda_exact.cuh); in the program for each of kVariants.
extern const KernelTemplate kExactKernel;

/// Queues one launch of `variant`, an instance of kExactKernel: traces the stripe and adds it to
/// the film.
cudaError_t trace_exact(const Variant& variant, const SceneView<TextureVolume>& scene,
                        const Stripe& stripe, const TraceTarget& target, cudaStream_t stream);

}  // namespace diaphane::render::cuda
