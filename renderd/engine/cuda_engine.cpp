#include "renderd/engine/cuda_engine.h"

#include <map>
#include <mutex>
#include <string>
#include <tuple>

#include "renderd/engine/cuda_error.h"
#include "renderd/engine/cuda_renderer.h"
#include "renderd/engine/cuda_trace.h"
#include "renderd/engine/cuda_volume.h"

namespace diaphane::render {
namespace {

/// Engines of devices of one kind in one process compile their kernels once: a kernel of CUDA's
/// libraries is no device's own.
std::shared_ptr<cuda::VariantStore> variants_for(const EngineOptions& options, int architecture) {
  using Key = std::tuple<KernelChoice, std::string, int>;
  static std::mutex mutex;
  static std::map<Key, std::weak_ptr<cuda::VariantStore>> stores;
  const std::scoped_lock lock(mutex);
  auto& known = stores[{options.kernels, options.kernel_cache, architecture}];
  auto store = known.lock();
  if (!store) {
    known = store = std::make_shared<cuda::VariantStore>(options.kernels, options.kernel_cache,
                                                         architecture, options.device);
  }
  return store;
}

/// What allocates and what launches makes the device the calling thread's current one before.
/// Volumes and renderers have their own streams; what they share is safe for threads.
class CudaEngine : public Engine {
 public:
  CudaEngine(EngineInfo info, const EngineOptions& options, int architecture)
      : info_(std::move(info)),
        device_(options.device),
        lean_memory_(options.lean_memory),
        shares_{variants_for(options, architecture),
                std::make_shared<cuda::DeviceShare<cuda::CudaDenoiser>>(),
                std::make_shared<cuda::DeviceShare<cuda::ExactWorkspace>>()} {}

  EngineInfo info() const override { return info_; }

  Result<std::shared_ptr<const DeviceVolume>> load(const volume::Volume& volume) override {
    DIAPHANE_CUDA_TRY(cudaSetDevice(device_));
    return cuda::CudaVolume::load(volume);
  }

 private:
  Result<std::unique_ptr<FrameRenderer>> make_renderer(std::shared_ptr<const DeviceVolume> volume,
                                                       std::uint64_t seed,
                                                       std::uint64_t first_sample,
                                                       Method method) override {
    auto ours = std::dynamic_pointer_cast<const cuda::CudaVolume>(std::move(volume));
    if (!ours || ours->device() != device_) {
      return fail(ErrorCode::kInternal, "the volume was loaded by another engine");
    }
    DIAPHANE_CUDA_TRY(cudaSetDevice(device_));
    // The exact walk's bricks and nodes are a fifth of a volume and up to twice as much.
    if (lean_memory_ && method.walk != Walk::kExact) method.walk = Walk::kTracking;
    return cuda::CudaRenderer::make(std::move(ours), shares_, seed, first_sample, method);
  }

  EngineInfo info_;
  int device_;
  bool lean_memory_;
  cuda::DeviceShares shares_;
};

}  // namespace

Result<std::unique_ptr<Engine>> make_cuda_engine(const EngineOptions& options) {
  int count = 0;
  DIAPHANE_CUDA_TRY(cudaGetDeviceCount(&count));
  if (count == 0) return fail(ErrorCode::kUnavailable, "no CUDA device is visible");
  if (options.device < 0 || options.device >= count) {
    return fail(ErrorCode::kUnavailable,
                "there is no CUDA device " + std::to_string(options.device) + ": " +
                    std::to_string(count) + " are visible",
                "device");
  }
  DIAPHANE_CUDA_TRY(cudaSetDevice(options.device));
  cudaDeviceProp properties{};
  DIAPHANE_CUDA_TRY(cudaGetDeviceProperties(&properties, options.device));
  // Also makes the context: a device that is broken or has no code of ours says so now.
  cudaFuncAttributes attributes{};
  DIAPHANE_CUDA_TRY(
      cudaFuncGetAttributes(&attributes, cuda::kTraceKernel.ahead_of_time(kAllFeatures).entry));
  return std::make_unique<CudaEngine>(
      EngineInfo{"cuda", properties.name, properties.totalGlobalMem,
                 double(properties.multiProcessorCount) * properties.maxThreadsPerMultiProcessor,
                 true},
      options, 10 * properties.major + properties.minor);
}

}  // namespace diaphane::render
