#pragma once

#include <map>
#include <string>

#include "common/result.h"
#include "renderd/schedule/ledger.h"

namespace diaphane::render::bench {

struct SceneCost {
  double seconds_per_pixel = 0;  ///< of one sample, the device full
  double noise = 0;              ///< error of a picture of one sample: e(n) = noise / sqrt(n)
};

/// What a device costs, measured by `diaphane-renderd-bench schedule --real` or taken from figures.
struct DeviceModel {
  std::string name;
  double parallel = 0;                   ///< as LedgerRules::device_parallel
  bool queues = false;                   ///< as EngineInfo::queues
  double quantum_seconds = 0;            ///< of a quantum beside its samples: launches, waiting
  double scene_seconds = 0;              ///< a new epoch: tables, a cleared film
  double picture_seconds = 0;            ///< a picture shown: tone map, smoothing, reading back
  double picture_seconds_per_pixel = 0;  ///< the same, for each pixel
  double picture_device_share = 0.45;    ///< of a picture's time: on the device, not on the way
  double look_seconds = 0;               ///< the runner's look at one session, before each round
  std::map<std::string, SceneCost> scenes;

  SceneCost scene(const std::string& name) const;
  /// Seconds that a picture takes alone.
  double picture(Canvas canvas) const;
  /// Seconds that a quantum of `samples` takes alone; less of the device full, more a sample.
  double alone(const std::string& scene, Canvas canvas, std::uint32_t samples) const;
  /// From an input to a good picture, alone on the device.
  double to_good(const std::string& scene, Canvas canvas) const;
};

/// "h200", "cpu2" (two cores), or a file that --real wrote.
Result<DeviceModel> device_model(const std::string& name);
std::string device_model_json(const DeviceModel& model);

}  // namespace diaphane::render::bench
