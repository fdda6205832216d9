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

#include "renderd/engine/cuda_kernel_cache.h"
#include "renderd/engine/cuda_nvrtc.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::cuda {

/// One kernel that can be launched: a template's instance for a set of features.
struct Variant {
  /// For cudaLaunchKernel and cudaFuncGetAttributes: a function's address or a cudaKernel_t.
  const void* entry = nullptr;
  Features features;
  KernelOrigin origin = KernelOrigin::kGeneral;
  double milliseconds = 0;  ///< that compiling or loading took
  bool from_cache = false;  ///< on disk
  int registers = 0;        ///< a thread
  std::uint64_t local_bytes = 0;
};

/// The kernels of one kind of device: those compiled ahead of time, and those compiled for the
/// scenes that were met, kept until the engine ends. Thread-safe. Nothing here fails for want of a
/// compiler: a kernel compiled ahead of time stands in, and says why.
class VariantStore {
 public:
  /// `architecture` as in Nvrtc::compile; `device`: one of those that it is for.
  VariantStore(KernelChoice choice, const std::string& cache_directory, int architecture,
               int device = 0);
  /// Waits for a compilation under way.
  ~VariantStore();
  VariantStore(const VariantStore&) = delete;
  VariantStore& operator=(const VariantStore&) = delete;

  /// The best kernel for a scene's features that there is now. KernelChoice::kExact: waits for the
  /// one compiled for just these. kStandIn: has that one compiled meanwhile; ask again.
  std::shared_ptr<const Variant> get(const KernelTemplate& kernel, Features needed);

  KernelChoice choice() const { return choice_; }
  /// Why kernels compiled ahead of time are used against the choice; empty when they are not.
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
    std::shared_ptr<const Variant> variant;  ///< null while it compiles, or when it cannot
    bool ended = false;
  };

  std::shared_ptr<const Variant> ahead_of_time(const KernelTemplate& kernel, Features needed);
  void work();
  /// Compiles or reads, and loads onto the device.
  Result<std::shared_ptr<const Variant>> make(const Key& key);
  std::string cache_key(const Key& key) const;
  void complain(const std::string& why);

  const KernelChoice choice_;
  const int architecture_;
  const int device_;
  const KernelCache cache_;
  std::shared_ptr<const Nvrtc> nvrtc_;  ///< null: none

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<Key, Entry> exact_;
  std::map<Key, std::shared_ptr<const Variant>> ahead_;
  std::deque<Key> queue_;
  std::vector<cudaLibrary_t> libraries_;
  std::string note_;
  bool ending_ = false;
  std::thread worker_;  ///< started by the first kernel to be compiled
};

}  // namespace diaphane::render::cuda
