#pragma once

#include <string>
#include <vector>

#include "renderd/cli/options.h"
#include "renderd/engine/frame_renderer.h"
#include "renderd/film/error_curve.h"

namespace diaphane::render::cli {

/// The outcome of a run.
struct Outcome {
  EngineInfo engine;
  Progress progress;
  std::uint64_t dropped_samples = 0;
  StopReason stopped_by = StopReason::kSamples;
  std::vector<std::string> features;
  KernelReport kernel;
  bool denoised = false;
  ErrorCurve curve;  ///< error after each pass
};

/// Returns the JSON of `--json`, whose keys are listed by `--help`. It contains no paths or names
/// from the input, only the options that describe the picture.
std::string report_json(const Options& options, const Outcome& outcome);

}  // namespace diaphane::render::cli
