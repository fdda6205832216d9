#pragma once

#include <cuda_runtime_api.h>

#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "renderd/engine/cuda/kernel_cache.h"
#include "renderd/engine/cuda/nvrtc.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::cuda {

/// A kernel that can be launched: an instance of a template for a set of features.
struct Variant {
  /// Function address or cudaKernel_t, for cudaLaunchKernel and cudaFuncGetAttributes.
  const void* entry = nullptr;
  Features features;
  KernelOrigin origin = KernelOrigin::kGeneral;
  double milliseconds = 0;  ///< time to compile or load it
  bool from_cache = false;  ///< read from disk instead of compiled
  int registers = 0;        ///< per thread
  std::uint64_t local_bytes = 0;
};

/// The kernels for one device architecture: those compiled ahead of time, and those compiled for
/// individual scenes, which are kept until the last engine ends. Thread-safe. If there is no
/// compiler, kernels compiled ahead of time are used, and note() gives the reason.
class VariantStore {
 public:
  /// `architecture` is ten times the compute capability. `device` is any device of that capability.
  VariantStore(KernelChoice choice, const std::string& cache_directory, int architecture,
               int device = 0);
  /// Waits for a compilation in progress.
  ~VariantStore();
  VariantStore(const VariantStore&) = delete;
  VariantStore& operator=(const VariantStore&) = delete;

  /// Returns the best available kernel for the features of a scene. With KernelChoice::kExact,
  /// waits until the kernel for exactly these features is compiled. With kStandIn, only starts this
  /// compilation; a later call returns its result.
  std::shared_ptr<const Variant> get(const KernelTemplate& kernel, Features needed);

  KernelChoice choice() const { return choice_; }
  /// Returns why kernels compiled ahead of time replace those of choice(), or an empty string.
  std::string note() const;

 private:
  struct Key {
    const KernelTemplate* kernel;
    std::uint32_t features;
    bool operator<(const Key& other) const {
      return std::tie(kernel, features) < std::tie(other.kernel, other.features);
    }
  };
  struct Entry {
    std::shared_ptr<const Variant> variant;  ///< null until it is compiled, or if that fails
    bool ended = false;
  };

  std::shared_ptr<const Variant> ahead_of_time(const KernelTemplate& kernel, Features needed);
  void work();
  /// Compiles the kernel or reads it from disk, and loads it onto the device.
  Result<std::shared_ptr<const Variant>> make(const Key& key);
  std::string cache_key(const Key& key) const;
  void complain(const std::string& why);

  const KernelChoice choice_;
  const int architecture_;
  const int device_;
  const KernelCache cache_;
  std::shared_ptr<const Nvrtc> nvrtc_;  ///< null if there is no compiler

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<Key, Entry> exact_;
  std::map<Key, std::shared_ptr<const Variant>> ahead_;
  std::deque<Key> queue_;
  std::vector<cudaLibrary_t> libraries_;
  std::string note_;
  bool ending_ = false;
  std::thread worker_;  ///< started by the first compilation
};

}  // namespace diaphane::render::cuda
