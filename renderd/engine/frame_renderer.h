#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/proto/scene.pb.h"
#include "common/result.h"
#include "renderd/engine/kernel_report.h"
#include "renderd/film/canvas.h"
#include "renderd/film/part.h"
#include "renderd/kernel/method.h"
#include "volume/volume.h"

namespace diaphane::render {

/// sRGB-like display picture: 8 bits, interleaved RGB, rows from the top, no padding.
struct PictureRgb8 {
  Canvas size;
  std::vector<std::uint8_t> pixels;
};

/// Linear radiance: interleaved RGB, rows from the top.
struct PictureRgbF {
  Canvas size;
  std::vector<float> pixels;
};

struct EngineInfo {
  std::string engine;              ///< "cpu" or "cuda"
  std::string device;              ///< "2 CPU threads", "NVIDIA H200"
  std::uint64_t memory_bytes = 0;  ///< all of the device's; of the machine's for the CPU
  /// Samples (of pixels) under way at once that keep it busy; 0: unknown. A quantum of fewer leaves
  /// room for another session's.
  double parallel = 0;
  /// Takes work while it has some, and goes on to it by itself when that ends.
  bool queues = false;
};

/// A volume on a device, shared by everybody who looks at it. Freed with the last holder.
class DeviceVolume {
 public:
  virtual ~DeviceVolume() = default;
  virtual const volume::Header& header() const = 0;
  virtual std::uint64_t device_bytes() const = 0;
};

/// What one call of FrameRenderer::render did.
struct Batch {
  std::uint32_t samples = 0;  ///< per pixel; fewer than asked when stopped
  double seconds = 0;
  std::uint64_t dropped_samples = 0;  ///< not finite: dropped and counted
  /// That other devices worked for the picture, as far as their parts came meanwhile.
  double helped_seconds = 0;
};

/// The state of the accumulated picture.
struct Progress {
  std::uint64_t samples = 0;  ///< per pixel
  double seconds = 0;         ///< of rendering, since the scene was set
  /// Estimated relative RMSE of the picture as displayed against the converged one, from
  /// independent halves; infinity below two samples.
  double error = 0;
};

/// Renders one session's picture progressively. Not thread-safe: called by one thread at a time,
/// not always the same. Different renderers of an engine may be called at once.
class FrameRenderer {
 public:
  virtual ~FrameRenderer() = default;
  /// Replaces scene and canvas and clears the film. On an error (kInvalid names the field) scene,
  /// canvas and picture stay as they were.
  virtual Result<void> set_scene(const diaphane::v1::Scene& scene, Canvas canvas) = 0;
  /// Adds up to `samples` samples per pixel; returns early, between rows or launches, when `stop`
  /// says so; then the unfinished part is discarded, so that every pixel has the same count.
  virtual Result<Batch> render(std::uint32_t samples, const std::function<bool()>& stop) = 0;
  virtual Progress progress() const = 0;
  /// Tone-mapped picture of what is accumulated.
  virtual Result<void> display(PictureRgb8& out) = 0;
  virtual Result<void> radiance(PictureRgbF& out) = 0;
  /// Which pixels' camera rays met contents of the volume so far, 1 or 0 a pixel, rows from the
  /// top: those that the error counts.
  virtual Result<void> contents(std::vector<std::uint8_t>& out) = 0;
  /// From the next scene on: the first samples also record what the two functions below need. Costs
  /// some of their speed and 16 bytes a pixel; without it they show the raw picture.
  virtual void prepare_denoising(bool) {}
  /// Whether somebody waits for what comes next (a first picture): it goes before what other
  /// renderers of the device have waiting, where the device can do that.
  virtual void hurry(bool) {}
  /// As display() and radiance(), smoothed as far as that makes the error less (film/denoise.h):
  /// the first pictures are, converged ones are not. False: it is the raw picture. Neither changes
  /// what is accumulated, nor the error that progress() tells, which is the raw picture's.
  virtual Result<bool> display_denoised(PictureRgb8& out) {
    return display(out).map([] { return false; });
  }
  virtual Result<bool> radiance_denoised(PictureRgbF& out) {
    return radiance(out).map([] { return false; });
  }
  // Of several devices that make one picture (renderd/composite); kUnsupported where an engine
  // cannot take part.

  /// What is rendered of this scene from the next sample on; what the film holds stays, and its
  /// progress counts the samples of the pixels that have the fewest. A new scene begins with the
  /// whole. kConflict unless the rows of the share before have one even number of samples of their
  /// own: a whole batch makes it so.
  virtual Result<void> set_share(const Share&) { return no_shares(); }
  /// Moves what was drawn since the last time out of the film, for another to merge; false, and
  /// nothing is moved, when it is nothing, an odd number of samples or, after a batch that was
  /// stopped, not the same everywhere.
  virtual Result<bool> take_film(FilmPart&) { return no_shares(); }
  /// As take_film(), for another device of the same engine in this process: the pixels may stay
  /// where they are.
  virtual Result<bool> take_film_here(FilmPart& out) { return take_film(out); }
  /// Adds what another device drew of this scene and canvas. kInvalid: it does not fit in.
  virtual Result<void> merge_film(const FilmPart&) { return no_shares(); }

  /// Names of the features compiled in for this scene, for reports.
  virtual std::vector<std::string> features() const = 0;
  /// Of the picture as it is now; after set_scene.
  virtual KernelReport report() const { return {}; }

 private:
  static tl::unexpected<Error> no_shares() {
    return fail(ErrorCode::kUnsupported, "this device renders whole pictures only");
  }
};

/// One device. Thread-safe.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual EngineInfo info() const = 0;
  virtual Result<std::shared_ptr<const DeviceVolume>> load(const volume::Volume& volume) = 0;
  /// `seed` and `first_sample` keep the sample ranges of different devices disjoint.
  Result<std::unique_ptr<FrameRenderer>> renderer(std::shared_ptr<const DeviceVolume> volume,
                                                  std::uint64_t seed, std::uint64_t first_sample,
                                                  Method method = {}) {
    return make_renderer(std::move(volume), seed, first_sample, method);
  }

 private:
  /// A default argument of a virtual function would be the caller's static type's.
  virtual Result<std::unique_ptr<FrameRenderer>> make_renderer(
      std::shared_ptr<const DeviceVolume> volume, std::uint64_t seed, std::uint64_t first_sample,
      Method method) = 0;
};

enum class EngineChoice { kAuto, kCpu, kCuda };

/// How an engine compiles and how much memory it may take; of no meaning to the CPU.
struct EngineOptions {
  KernelChoice kernels = KernelChoice::kExact;
  std::string kernel_cache;  ///< directory for compiled kernels; empty: none is kept on disk
  /// At most 5% of device memory beside the volume's voxels: leaves out acceleration structures
  /// that take more.
  bool lean_memory = false;
  int device = 0;  ///< of those that are visible
};

/// DIAPHANE_KERNEL_CACHE (empty: none); else diaphane/kernels in XDG_CACHE_HOME or in ~/.cache;
/// empty where none of these is set.
std::string default_kernel_cache();

/// "exact", "stand-in", "ahead-of-time", "general".
std::optional<KernelChoice> kernel_choice(std::string_view name);

/// From DIAPHANE_KERNELS (default: exact), default_kernel_cache() and DIAPHANE_LEAN_MEMORY (1 or 0,
/// the default). kInvalid names a variable that says something else.
Result<EngineOptions> engine_options_from_environment();

/// kAuto: CUDA when it was compiled in and a device answers, else the CPU. `threads` 0: all cores.
Result<std::unique_ptr<Engine>> make_engine(EngineChoice choice, unsigned threads,
                                            const EngineOptions& options);
/// With the options that the environment names.
Result<std::unique_ptr<Engine>> make_engine(EngineChoice choice, unsigned threads);

}  // namespace diaphane::render
