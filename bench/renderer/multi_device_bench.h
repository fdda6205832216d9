#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/renderer/reference.h"
#include "renderd/composite/composite_renderer.h"

// Several devices that render one picture (thesis 5.1.2 and 8.2): how much the error falls (Figure
// 11), how the picture looks (Figure 12), and how long each way of dividing takes to reach an
// error.

namespace diaphane::render::bench {

/// The devices of this process, each with a copy of the volume.
struct DeviceSet {
  std::vector<std::unique_ptr<Engine>> engines;
  std::vector<std::shared_ptr<const DeviceVolume>> volumes;
};

/// Opens `count` CUDA devices, or as many CPU engines that share `threads` (0: all cores).
Result<DeviceSet> open_devices(EngineChoice choice, unsigned count, unsigned threads,
                               const volume::Volume& volume);

/// The error of pictures to which each device contributed `passes`.
struct ErrorRow {
  std::uint32_t passes = 0;
  unsigned devices = 0;
  bool low_discrepancy = false;
  double rmse = 0;      ///< error of the displayed picture against the reference
  double off = 0;       ///< relative deviation of the error ratio from 1 / sqrt(devices)
  double estimate = 0;  ///< error that the compositor estimates
};
struct ErrorOptions {
  std::vector<unsigned> devices;      ///< ascending, starting with 1
  std::vector<std::uint32_t> passes;  ///< even numbers
  std::uint32_t repeats = 6;
  Walk walk = Walk::kAuto;
};
/// Renders with the compositor, with the given number of passes per device.
Result<std::vector<ErrorRow>> measure_errors(const DeviceSet& devices, const Subject& subject,
                                             const Reference& reference,
                                             const ErrorOptions& options);

/// Returns pairs of pictures of one device (left) and `devices` (right), one pair per number of
/// passes from top to bottom.
Result<PictureRgb8> side_by_side(const DeviceSet& devices, const Subject& subject, unsigned count,
                                 const std::vector<std::uint32_t>& passes);

/// The time from a new scene until the estimated error is at most `target`.
struct TimeRow {
  std::string division;  ///< "one", "averaging", "tiles", "chosen"
  Canvas canvas;
  double target = 0;
  double milliseconds = 0, spread = 0;  ///< median
  double first = 0;                     ///< median time until every pixel has a sample
  double samples = 0;
  double megabytes = 0;  ///< median data moved between devices
  std::string took;      ///< division of the last picture: what "chosen" chose
};
struct TimeOptions {
  std::vector<Canvas> canvases;
  std::vector<double> targets;
  std::uint32_t repeats = 7;
  bool smoothed = false;  ///< whether guides for the denoiser are rendered, as in sessions
  double warm_up = 1;     ///< seconds
  double longest = 60;    ///< time limit in seconds for one picture
  std::function<void(const TimeRow&)> each;
};
/// Measures one device and all of `devices`, whose copies of the volume are released first.
Result<std::vector<TimeRow>> measure_times(DeviceSet devices, const volume::Volume& volume,
                                           const diaphane::v1::Scene& scene,
                                           const TimeOptions& options);

}  // namespace diaphane::render::bench
