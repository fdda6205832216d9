#pragma once

#include "renderd/engine/cuda/trace_types.h"

namespace diaphane::render::cuda {

/// Adds one batch per pixel, like the trace kernels at their end. Both arrays are on the device.
cudaError_t add_batches(const TraceTarget& target, const PixelBatch* batches, std::uint64_t pixels,
                        cudaStream_t stream);

}  // namespace diaphane::render::cuda
