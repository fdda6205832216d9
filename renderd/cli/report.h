#pragma once

#include <string>
#include <vector>

#include "renderd/cli/options.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::cli {

/// What a run did.
struct Outcome {
  EngineInfo engine;
  Progress progress;
  std::uint64_t dropped_samples = 0;
  StopReason stopped_by = StopReason::kSamples;
  std::vector<std::string> features;
  KernelReport kernel;
  bool denoised = false;
};

/// The JSON of `--json`; its keys are listed by `--help`. Holds nothing of the input but what the
/// options say of the picture: no path, no name.
std::string report_json(const Options& options, const Outcome& outcome);

}  // namespace diaphane::render::cli
