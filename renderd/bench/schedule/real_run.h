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

/// Samples of a 512 x 512 picture a second, of one renderer alone in long quanta.
Result<double> rate_alone(const Stage& stage, double scale, double seconds);
/// The same, of all of some resting sessions together, by the runner: with its decisions, error
/// estimates and pictures. What is missing to rate_alone is lost to switching.
Result<double> rate_shared(const Stage& stage, double scale, std::size_t sessions, double seconds);

}  // namespace diaphane::render::bench
