#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "api/proto/scene.pb.h"
#include "common/result.h"
#include "renderd/engine/kernel_report.h"
#include "renderd/film/canvas.h"

namespace diaphane::render {

/// The result of one call of ProgressiveRenderer::render.
struct Batch {
  std::uint32_t samples = 0;          ///< per pixel; fewer than requested if the call was stopped
  double seconds = 0;                 ///< wall-clock time of the call
  std::uint64_t dropped_samples = 0;  ///< samples that were not finite and were therefore dropped
  /// Time that other devices spent on this picture, for parts that arrived during the call.
  double helped_seconds = 0;
  /// Whether the samples come from the slower and better estimator that follows a draft. A batch
  /// never has samples of both estimators.
  bool refined = false;
};

/// The state of the accumulated picture.
struct Progress {
  std::uint64_t samples = 0;  ///< per pixel, including those of a draft
  double seconds = 0;         ///< rendering time since the scene was set
  /// Estimated relative RMSE of the displayed picture compared with the converged one, computed
  /// from two independent halves of the samples. Infinity for fewer than two samples.
  double error = 0;
  /// Stops that automatic exposure adds to the exposure of the scene, measured with the error.
  double stops = 0;
};

/// Accumulates the samples of one scene.
class ProgressiveRenderer {
 public:
  virtual ~ProgressiveRenderer() = default;

  /// Replaces scene and canvas and clears the film. If it returns kInvalid (with the name of the
  /// field) or kOutOfMemory, scene, canvas and picture stay as they were.
  virtual Result<void> set_scene(const diaphane::v1::Scene& scene, Canvas canvas) = 0;
  /// Adds up to `samples` samples per pixel, fewer where a draft ends. Calls `stop` between tiles
  /// or launches, and returns early if the result is true. The next call then continues the
  /// unfinished work. Until then, the CPU leaves it out of the picture, and on a GPU the upper rows
  /// have more samples than the others. Fails if no scene is set, and with kOutOfMemory or
  /// kDeviceLost if the device fails.
  virtual Result<Batch> render(std::uint32_t samples, const std::function<bool()>& stop) = 0;
  virtual Progress progress() const = 0;
  /// Sets the precedence of the next work. It is above 0 for work that a user waits for, such as
  /// the first picture after an input. On a GPU, work above 0 runs before the queued work of other
  /// renderers. On the CPU, work of a higher precedence pauses work of a lower precedence.
  virtual void set_precedence(unsigned) {}
  /// Raises the precedence of the current work, on the CPU only. Thread-safe.
  virtual void raise_precedence(unsigned) {}

  /// Returns the names of the features that this scene needs, for reports.
  virtual std::vector<std::string> features() const = 0;
  /// Describes how the current picture is rendered. Valid after set_scene().
  virtual KernelReport report() const { return {}; }
};

}  // namespace diaphane::render
