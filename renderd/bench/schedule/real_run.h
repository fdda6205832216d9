#pragma once

#include <map>
#include <memory>

#include "renderd/bench/schedule/simulation.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::bench {

/// A device and what is rendered on it.
struct Stage {
  Engine& engine;
  std::shared_ptr<const DeviceVolume> volume;
  std::map<std::string, v1::Scene> scenes;  ///< of kTraceScenes
  double scale = 1;                         ///< of the traces' viewports, for slow devices
  LedgerRules rules;

  Canvas canvas(Canvas viewport) const;
};

/// What it costs: some seconds of rendering. Also compiles every kernel that the traces need.
Result<DeviceModel> measure_costs(const Stage& stage);

/// A trace in real time: the runner and the renderers of `renderd`, with viewers that take every
/// picture at once. Coding and sending are left out. A gesture's inputs turn the camera.
Result<TraceRun> run_real(const Trace& trace, const Stage& stage, const DeviceModel& model,
                          std::unique_ptr<Policy> policy);

}  // namespace diaphane::render::bench
