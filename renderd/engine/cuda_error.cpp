#include "renderd/engine/cuda_error.h"

#include <string>

namespace diaphane::render::cuda {

Error error_of(cudaError_t status) {
  // Takes an error that is not sticky off the thread, so that the next call does not report it
  // again.
  cudaGetLastError();
  const std::string said =
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
      return {ErrorCode::kUnavailable, "no CUDA device answers (" + said + ")", {}};
    default:
      return {ErrorCode::kDeviceLost, "the CUDA device is lost (" + said + ")", {}};
  }
}

}  // namespace diaphane::render::cuda
