#pragma once

#include "renderd/engine/cuda_trace_types.h"

namespace diaphane::render::cuda {

/// Adds one batch a pixel, as the trace kernels do at their end. Both are on the device.
cudaError_t add_batches(const TraceTarget& target, const PixelBatch* batches, std::uint64_t pixels,
                        cudaStream_t stream);

}  // namespace diaphane::render::cuda
