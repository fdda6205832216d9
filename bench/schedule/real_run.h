#pragma once

#include <map>
#include <memory>

#include "bench/schedule/simulation.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::bench {

/// Scales a trace's viewport for a slow device, with even sides of at least 16 pixels.
Canvas scaled(Canvas viewport, double scale);

/// A device and what it renders.
struct Stage {
  Engine& engine;
  std::shared_ptr<const DeviceVolume> volume;
  std::map<std::string, v1::Scene> scenes;  ///< by name, of kTraceScenes
  LedgerRules rules;
};

/// Measures the device's costs on viewports of that scale, which takes some seconds. Also compiles
/// every kernel that the traces need.
Result<DeviceModel> measure_costs(const Stage& stage, double scale);

/// Plays a trace in real time with the runner and the renderers of `renderd`. Viewers take every
/// picture at once, without encoding and sending. The inputs of a gesture turn the camera.
Result<TraceRun> run_real(const Trace& trace, const Stage& stage, const DeviceModel& model,
                          std::unique_ptr<Policy> policy);

/// Returns samples per second of a 512 x 512 picture for one renderer alone with long quanta.
Result<double> rate_alone(const Stage& stage, double scale, double seconds);
/// Returns the total rate of several resting sessions in the runner, including its decisions, error
/// estimates and pictures. The difference to rate_alone is lost to switching.
Result<double> rate_shared(const Stage& stage, double scale, std::size_t sessions, double seconds);

}  // namespace diaphane::render::bench
