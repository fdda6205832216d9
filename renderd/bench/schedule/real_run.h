#pragma once

#include <map>
#include <memory>

#include "renderd/bench/schedule/simulation.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::bench {

/// A trace's viewport for a slow device: even sides, 16 pixels at least.
Canvas scaled(Canvas viewport, double scale);

/// A device and what is rendered on it.
struct Stage {
  Engine& engine;
  std::shared_ptr<const DeviceVolume> volume;
  std::map<std::string, v1::Scene> scenes;  ///< of kTraceScenes
  LedgerRules rules;
};

/// What it costs, on viewports of that scale: some seconds of rendering. Also compiles every kernel
/// that the traces need.
Result<DeviceModel> measure_costs(const Stage& stage, double scale);

/// A trace in real time: the runner and the renderers of `renderd`, with viewers that take every
/// picture at once. Coding and sending are left out. A gesture's inputs turn the camera.
Result<TraceRun> run_real(const Trace& trace, const Stage& stage, const DeviceModel& model,
                          std::unique_ptr<Policy> policy);

}  // namespace diaphane::render::bench
