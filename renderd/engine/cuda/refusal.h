#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "common/result.h"

// Explains to the operator why the CUDA engine cannot use a device. This header does not include
// CUDA, so that its tests run in every build.

namespace diaphane::render::cuda {

/// The oldest compute capability with code in the program, times ten (cmake/Cuda.cmake).
inline constexpr int kOldestCapability = 75;

struct DeviceDescription {
  std::string name;
  int capability = 0;              ///< compute capability times ten, so 90 is 9.0
  std::uint64_t memory_bytes = 0;  ///< total memory of the device
};

/// Formats a number such as 90 as "9.0".
inline std::string with_point(int tens) {
  return std::to_string(tens / 10) + "." + std::to_string(tens % 10);
}

/// Adds the likely cause to an error of the runtime that found no device. The versions are those
/// that CUDA reports (13020 is 13.2); `driver` is 0 if no driver is installed.
inline Error explain_no_device(Error error, int driver, int runtime) {
  if (error.code != ErrorCode::kUnavailable) return error;
  if (driver == 0) {
    error.message = "no CUDA device is available: no NVIDIA driver is installed";
  } else if (driver / 1000 < runtime / 1000) {
    error.message = "no CUDA device is available: the NVIDIA driver supports CUDA up to " +
                    std::to_string(driver / 1000) + "." + std::to_string(driver % 1000 / 10) +
                    ", but CUDA " + std::to_string(runtime / 1000) + " is required";
  }
  return error;
}

/// Adds the device and the likely cause to an error from starting the device.
inline Error explain_refusal(Error error, const DeviceDescription& device) {
  if (error.code == ErrorCode::kUnavailable && device.capability < kOldestCapability) {
    error.message = device.name + " has compute capability " + with_point(device.capability) +
                    ", but " + with_point(kOldestCapability) + " or later is required";
  } else if (error.code == ErrorCode::kOutOfMemory) {
    error.message = device.name + " (" + std::to_string(device.memory_bytes >> 20) +
                    " MiB) has too little free memory to start the CUDA engine";
  } else {
    error.message = device.name + ": " + error.message;
  }
  return error;
}

}  // namespace diaphane::render::cuda
