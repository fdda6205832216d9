#pragma once

#include "renderd/engine/cuda/nvrtc.h"
#include "renderd/engine/cuda/trace_types.h"
#include "renderd/engine/cuda/variants.h"

namespace diaphane::render::cuda {

/// The tracking kernel (trace.cuh), compiled into the program for each of kVariants.
extern const KernelTemplate kTraceKernel;

/// Queues one launch of `variant`, an instance of kTraceKernel, which traces the stripe and adds it
/// to the film.
cudaError_t trace(const Variant& variant, const SceneView<TextureVolume>& scene,
                  const Stripe& stripe, const TraceTarget& target, cudaStream_t stream);

}  // namespace diaphane::render::cuda
