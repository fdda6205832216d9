#include "renderd/engine/cuda_engine.h"

#include <string>

#include "renderd/engine/cuda_error.h"
#include "renderd/engine/cuda_renderer.h"
#include "renderd/engine/cuda_trace.h"
#include "renderd/engine/cuda_volume.h"

namespace diaphane::render {
namespace {

/// Device 0 of those that are visible is every thread's current device, so no call needs to choose
/// it. Volumes and renderers have their own streams; what they share is safe for threads.
class CudaEngine : public Engine {
 public:
  CudaEngine(EngineInfo info, const EngineOptions& options, int architecture)
      : info_(std::move(info)),
        lean_memory_(options.lean_memory),
        shares_{std::make_shared<cuda::VariantStore>(options.kernels, options.kernel_cache,
                                                     architecture),
                std::make_shared<cuda::DeviceShare<cuda::CudaDenoiser>>(),
                std::make_shared<cuda::DeviceShare<cuda::ExactWorkspace>>()} {}

  EngineInfo info() const override { return info_; }

  Result<std::shared_ptr<const DeviceVolume>> load(const volume::Volume& volume) override {
    return cuda::CudaVolume::load(volume);
  }

 private:
  Result<std::unique_ptr<FrameRenderer>> make_renderer(std::shared_ptr<const DeviceVolume> volume,
                                                       std::uint64_t seed,
                                                       std::uint64_t first_sample,
                                                       Method method) override {
    auto ours = std::dynamic_pointer_cast<const cuda::CudaVolume>(std::move(volume));
    if (!ours) return fail(ErrorCode::kInternal, "the volume was loaded by another engine");
    // The exact walk's bricks and nodes are a fifth of a volume and up to twice as much.
    if (lean_memory_ && method.walk != Walk::kExact) method.walk = Walk::kTracking;
    return cuda::CudaRenderer::make(std::move(ours), shares_, seed, first_sample, method);
  }

  EngineInfo info_;
  bool lean_memory_;
  cuda::DeviceShares shares_;
};

}  // namespace

Result<std::unique_ptr<Engine>> make_cuda_engine(const EngineOptions& options) {
  int count = 0;
  DIAPHANE_CUDA_TRY(cudaGetDeviceCount(&count));
  if (count == 0) return fail(ErrorCode::kUnavailable, "no CUDA device is visible");
  cudaDeviceProp properties{};
  DIAPHANE_CUDA_TRY(cudaGetDeviceProperties(&properties, 0));
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
