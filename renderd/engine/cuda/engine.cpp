#include "renderd/engine/cuda/engine.h"

#include <map>
#include <mutex>
#include <string>
#include <tuple>

#include "renderd/engine/cuda/error.h"
#include "renderd/engine/cuda/refusal.h"
#include "renderd/engine/cuda/renderer.h"
#include "renderd/engine/cuda/trace.h"
#include "renderd/engine/cuda/volume.h"

namespace diaphane::render {
namespace {

/// Returns the kernels that all engines of one architecture in this process share, so that each is
/// compiled only once. That works because a kernel of a CUDA library is not bound to one device.
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

/// The CUDA engine. Functions that allocate or launch first make the device current for the calling
/// thread. Volumes and renderers have separate streams, and what they share is thread-safe.
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
    // The bricks and nodes of the exact walk would take between a fifth and twice the memory of the
    // volume.
    if (lean_memory_ && method.walk != Walk::kExact) method.walk = Walk::kTracking;
    return cuda::CudaRenderer::make(std::move(ours), shares_, seed, first_sample, method);
  }

  EngineInfo info_;
  int device_;
  bool lean_memory_;
  cuda::DeviceShares shares_;
};

/// Creates the device's context and looks up a kernel, so that a broken device, or one for which
/// the program contains no code, fails here and not in the first picture.
cudaError_t start_device(int device) {
  if (const cudaError_t status = cudaSetDevice(device); status != cudaSuccess) return status;
  cudaFuncAttributes attributes{};
  return cudaFuncGetAttributes(&attributes, cuda::kTraceKernel.ahead_of_time(kAllFeatures).entry);
}

}  // namespace

int visible_cuda_devices() {
  int count = 0;
  return cudaGetDeviceCount(&count) == cudaSuccess ? count : 0;
}

Result<std::unique_ptr<Engine>> make_cuda_engine(const EngineOptions& options) {
  int count = 0;
  if (const cudaError_t status = cudaGetDeviceCount(&count); status != cudaSuccess) {
    int driver = 0;
    cudaDriverGetVersion(&driver);
    return tl::unexpected(cuda::explain_no_device(cuda::error_of(status), driver, CUDART_VERSION));
  }
  if (count == 0) return fail(ErrorCode::kUnavailable, "no CUDA device is visible");
  if (options.device < 0 || options.device >= count) {
    return fail(ErrorCode::kUnavailable,
                "CUDA device " + std::to_string(options.device) +
                    " does not exist; visible devices: " + std::to_string(count),
                "device");
  }
  cudaDeviceProp properties{};
  DIAPHANE_CUDA_TRY(cudaGetDeviceProperties(&properties, options.device));
  if (const cudaError_t status = start_device(options.device); status != cudaSuccess) {
    const int capability = 10 * properties.major + properties.minor;
    return tl::unexpected(cuda::explain_refusal(
        cuda::error_of(status), {properties.name, capability, properties.totalGlobalMem}));
  }
  return std::make_unique<CudaEngine>(
      EngineInfo{"cuda", properties.name, properties.totalGlobalMem,
                 double(properties.multiProcessorCount) * properties.maxThreadsPerMultiProcessor,
                 true},
      options, 10 * properties.major + properties.minor);
}

}  // namespace diaphane::render
