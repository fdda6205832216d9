#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "common/result.h"
#include "renderd/engine/film_exchange.h"
#include "renderd/engine/kernel_report.h"
#include "renderd/engine/picture_source.h"
#include "renderd/engine/progressive_renderer.h"
#include "renderd/kernel/method.h"
#include "volume/alignment.h"
#include "volume/volume.h"

namespace diaphane::render {

struct EngineInfo {
  std::string engine;              ///< "cpu" or "cuda"
  std::string device;              ///< "2 CPU threads", "NVIDIA H200"
  std::uint64_t memory_bytes = 0;  ///< total memory of the device, or of the machine for the CPU
  /// Number of samples in flight that keep the device busy; 0 if unknown. Work of fewer samples at
  /// a time leaves room for another session.
  double parallel = 0;
  /// Whether the device accepts work while it is busy, and starts it when the current work ends.
  bool queues = false;
};

/// A volume in the memory of a device, shared by all sessions that view it. It is freed with its
/// last owner.
class DeviceVolume {
 public:
  virtual ~DeviceVolume() = default;
  virtual const volume::Header& header() const = 0;
  /// Returns the bytes of device memory that the volume takes.
  virtual std::uint64_t device_bytes() const = 0;
};

/// Renders one session's picture progressively. Code that needs only one of the three interfaces
/// takes that interface. A renderer is not thread-safe: only one thread at a time may call it, but
/// the thread may change. Different renderers of an engine may be called concurrently.
class FrameRenderer : public ProgressiveRenderer, public PictureSource, public FilmExchange {
 public:
  /// Sets the volume of the next scene, such as another phase of a scan. The current scene and its
  /// picture keep theirs until set_scene() succeeds. Fails with kInternal if another engine loaded
  /// the volume.
  virtual Result<void> set_volume(std::shared_ptr<const DeviceVolume>) {
    return fail(ErrorCode::kUnsupported, "this renderer always shows the same volume");
  }
  /// Sets the second scan of the following scenes, and how it lies (Scene.overlay). Null removes
  /// it. The current scene and its picture keep theirs until set_scene() succeeds. Fails with
  /// kInternal if another engine loaded the volume.
  virtual Result<void> set_second(std::shared_ptr<const DeviceVolume>, const volume::Matrix&) {
    return fail(ErrorCode::kUnsupported, "this renderer shows one scan");
  }
};

/// A rendering device. Thread-safe.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual EngineInfo info() const = 0;
  /// Copies the voxels to the device. Returns kInvalid for a volume that cannot be rendered,
  /// kOutOfMemory if it does not fit, and kUnavailable or kDeviceLost if the device fails.
  virtual Result<std::shared_ptr<const DeviceVolume>> load(const volume::Volume& volume) = 0;
  /// Makes a renderer of a volume that this engine has loaded (otherwise kInternal). `seed` and
  /// `first_sample` keep the sample ranges of different devices disjoint.
  Result<std::unique_ptr<FrameRenderer>> renderer(std::shared_ptr<const DeviceVolume> volume,
                                                  std::uint64_t seed, std::uint64_t first_sample,
                                                  Method method = {}) {
    return make_renderer(std::move(volume), seed, first_sample, method);
  }

 private:
  /// Implements renderer(), which is not virtual because the default argument of a virtual function
  /// depends on the static type.
  virtual Result<std::unique_ptr<FrameRenderer>> make_renderer(
      std::shared_ptr<const DeviceVolume> volume, std::uint64_t seed, std::uint64_t first_sample,
      Method method) = 0;
};

enum class EngineChoice { kAuto, kCpu, kCuda };

/// Options of an engine. All except `film_bytes` concern CUDA only.
struct EngineOptions {
  KernelChoice kernels = KernelChoice::kExact;
  std::string kernel_cache;  ///< directory for compiled kernels; empty if none are kept on disk
  /// Replaces the exact walk by tracking, because its acceleration structures would take between a
  /// fifth and twice the memory of the voxels.
  bool lean_memory = false;
  /// Memory limit of the CPU engine for the pictures of all sessions (make_cpu_engine), in bytes.
  std::uint64_t film_bytes = 0;
  int device = 0;  ///< index among the visible CUDA devices
};

/// Returns DIAPHANE_KERNEL_CACHE if it is set, where an empty value disables the cache. Otherwise
/// returns diaphane/kernels in XDG_CACHE_HOME or in ~/.cache, or an empty string if neither
/// XDG_CACHE_HOME nor HOME is an absolute path.
std::string default_kernel_cache();

/// Parses "exact", "stand-in", "ahead-of-time" or "general". Returns nothing for another name.
std::optional<KernelChoice> kernel_choice(std::string_view name);

/// Reads DIAPHANE_KERNELS (a name for kernel_choice(), "exact" by default), default_kernel_cache()
/// and DIAPHANE_LEAN_MEMORY (1, or 0 by default). Fails with kInvalid and the name of the variable
/// if its value is invalid.
Result<EngineOptions> engine_options_from_environment();

/// Returns the number of CUDA devices that this process sees, which is 0 without a usable driver.
int visible_devices();

/// Receives the reason why EngineChoice::kAuto did not choose CUDA.
using FallbackReport = std::function<void(const Error& reason)>;

/// Makes the chosen engine. kAuto chooses CUDA if the program contains the CUDA engine and
/// `options.device` can be used. Otherwise kAuto calls `on_fallback`, if it is set, and chooses the
/// CPU. `threads` is the number of threads of the CPU engine; 0 means one per core.
Result<std::unique_ptr<Engine>> make_engine(EngineChoice choice, unsigned threads,
                                            const EngineOptions& options,
                                            const FallbackReport& on_fallback = {});
/// Makes the chosen engine with the options from engine_options_from_environment().
Result<std::unique_ptr<Engine>> make_engine(EngineChoice choice, unsigned threads);

}  // namespace diaphane::render
