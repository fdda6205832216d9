#include "renderd/engine/cuda/error.h"

#include <string>

namespace diaphane::render::cuda {

Error error_of(cudaError_t status) {
  // Clears an error that is not sticky, so that the next call on this thread does not report it
  // again.
  cudaGetLastError();
  const std::string description =
      std::string(cudaGetErrorName(status)) + ": " + cudaGetErrorString(status);
  switch (status) {
    case cudaErrorMemoryAllocation:
      return {ErrorCode::kOutOfMemory, "not enough memory on the device", {}};
    case cudaErrorNoDevice:
    case cudaErrorInsufficientDriver:
    case cudaErrorInitializationError:
    case cudaErrorSystemDriverMismatch:
    case cudaErrorSystemNotReady:
    case cudaErrorStubLibrary:
    case cudaErrorDevicesUnavailable:
    case cudaErrorNoKernelImageForDevice:
    case cudaErrorUnsupportedPtxVersion:
    case cudaErrorInvalidDeviceFunction:
      return {ErrorCode::kUnavailable, "no CUDA device is available (" + description + ")", {}};
    default:
      return {ErrorCode::kDeviceLost, "the CUDA device was lost (" + description + ")", {}};
  }
}

}  // namespace diaphane::render::cuda
