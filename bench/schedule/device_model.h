#pragma once

#include <map>
#include <string>

#include "common/result.h"
#include "renderd/schedule/ledger.h"

namespace diaphane::render::bench {

struct SceneCost {
  double seconds_per_pixel = 0;  ///< time of one sample on a fully used device
  double noise = 0;              ///< error of a picture with one sample: e(n) = noise / sqrt(n)
};

/// Costs of a device, measured by `diaphane-renderd-bench schedule --real` or taken from figures.
struct DeviceModel {
  std::string name;
  double parallel = 0;         ///< as LedgerRules::device_parallel
  bool queues = false;         ///< as EngineInfo::queues
  double quantum_seconds = 0;  ///< overhead of a quantum for launching and waiting
  double scene_seconds = 0;    ///< time of a new epoch: tables and a cleared film
  double picture_seconds = 0;  ///< time of a displayed picture: tone mapping, smoothing, reading
                               ///< back
  double picture_seconds_per_pixel = 0;  ///< further time per pixel of a displayed picture
  /// Share of a picture's time on the device rather than in transfer.
  double picture_device_share = 0.45;
  double look_seconds = 0;  ///< time of the runner's check of one session before each round
  std::map<std::string, SceneCost> scenes;

  SceneCost scene(const std::string& name) const;
  /// Returns the seconds that a picture takes alone.
  double picture(Canvas canvas) const;
  /// Returns the seconds that a quantum of `samples` takes alone. A quantum that fills less of the
  /// device takes longer per sample.
  double alone(const std::string& scene, Canvas canvas, std::uint32_t samples) const;
  /// Returns the seconds from an input to a good picture, alone on the device.
  double to_good(const std::string& scene, Canvas canvas) const;
};

/// Returns "h200", "cpu2" (two cores), or the model in a file that --real wrote.
Result<DeviceModel> device_model(const std::string& name);
std::string device_model_json(const DeviceModel& model);

}  // namespace diaphane::render::bench
