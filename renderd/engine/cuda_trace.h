#pragma once

#include "renderd/engine/cuda_nvrtc.h"
#include "renderd/engine/cuda_trace_types.h"
#include "renderd/engine/cuda_variants.h"

namespace diaphane::render::cuda {

/// Tracking (cuda_trace.cuh); in the program for each of kVariants.
extern const KernelTemplate kTraceKernel;

/// Queues one launch of `variant`, an instance of kTraceKernel: traces the stripe and adds it to
/// the film.
cudaError_t trace(const Variant& variant, const SceneView<TextureVolume>& scene,
                  const Stripe& stripe, const TraceTarget& target, cudaStream_t stream);

}  // namespace diaphane::render::cuda
