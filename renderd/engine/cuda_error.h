#pragma once

#include <cuda_runtime_api.h>

#include "common/result.h"

namespace diaphane::render::cuda {

/// What a CUDA status means to a caller: kOutOfMemory leaves the context whole and nothing half
/// done; kUnavailable is no device or no driver; anything else breaks the context for the whole
/// process and is kDeviceLost.
Error error_of(cudaError_t status);

}  // namespace diaphane::render::cuda

/// Returns from a function of Result<T> when a CUDA call fails. A macro because it returns.
#define DIAPHANE_CUDA_TRY(call)                                                                   \
  do {                                                                                            \
    if (const cudaError_t cuda_status_ = (call); cuda_status_ != cudaSuccess)                     \
      return tl::unexpected<::diaphane::Error>(::diaphane::render::cuda::error_of(cuda_status_)); \
  } while (false)

/// Likewise for a call that is itself a Result.
#define DIAPHANE_TRY(call)                                                  \
  do {                                                                      \
    if (auto result_ = (call); !result_)                                    \
      return tl::unexpected<::diaphane::Error>(std::move(result_).error()); \
  } while (false)
