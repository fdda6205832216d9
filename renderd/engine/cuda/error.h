#pragma once

#include <cuda_runtime_api.h>

#include "common/result.h"

namespace diaphane::render::cuda {

/// Translates a CUDA status. After kOutOfMemory, the context still works and the call had no
/// effect. kUnavailable means that there is no usable device or driver. Any other status breaks the
/// context for the whole process and becomes kDeviceLost.
Error error_of(cudaError_t status);

}  // namespace diaphane::render::cuda

/// Returns the error of a failed CUDA call from the enclosing function, whose type is Result<T>.
#define DIAPHANE_CUDA_TRY(call)                                                                   \
  do {                                                                                            \
    if (const cudaError_t cuda_status_ = (call); cuda_status_ != cudaSuccess)                     \
      return tl::unexpected<::diaphane::Error>(::diaphane::render::cuda::error_of(cuda_status_)); \
  } while (false)
