#pragma once

#include <functional>
#include <string>
#include <vector>

#include "renderd/bench/reference.h"
#include "renderd/composite/composite_renderer.h"

// Several devices that make one picture (thesis 5.1.2 and 8.2): how much less error they leave
// (Figure 11), how that looks (Figure 12), and what each way of dividing costs until an error is
// reached.

namespace diaphane::render::bench {

/// The devices of this process, with a copy of the volume each.
struct ManyDevices {
  std::vector<std::unique_ptr<Engine>> engines;
  std::vector<std::shared_ptr<const DeviceVolume>> volumes;
};

/// `count` CUDA devices, or as many CPU engines that share `threads` (0: all cores).
Result<ManyDevices> open_devices(EngineChoice choice, unsigned count, unsigned threads,
                                 const volume::Volume& volume);

/// The error of pictures of which each device drew `passes`.
struct ErrorRow {
  std::uint32_t passes = 0;
  unsigned devices = 0;
  bool low_discrepancy = false;
  double rmse = 0;      ///< on the screen, against the reference
  double off = 0;       ///< of the ratio to one device from 1 / sqrt(devices), relative
  double estimate = 0;  ///< as the compositor tells it
};
struct ErrorWish {
  std::vector<unsigned> devices;      ///< ascending; the first is 1
  std::vector<std::uint32_t> passes;  ///< even
  std::uint32_t repeats = 6;
  Walk walk = Walk::kAuto;
};
/// Through the compositor, with as many passes of each device as were asked for.
Result<std::vector<ErrorRow>> measure_errors(const ManyDevices& devices, const Subject& subject,
                                             const Reference& reference, const ErrorWish& wish);

/// Left one device, right `devices`; one pair below the other for each number of passes.
Result<PictureRgb8> side_by_side(const ManyDevices& devices, const Subject& subject, unsigned count,
                                 const std::vector<std::uint32_t>& passes);

/// From a new scene until the estimated error is at most `target`.
struct TimeRow {
  std::string division;  ///< "one", "averaging", "tiles", "chosen"
  Canvas canvas;
  double target = 0;
  double milliseconds = 0, spread = 0;  ///< median
  double first = 0;                     ///< of those: until every pixel has a sample; median
  double samples = 0;
  double megabytes = 0;  ///< moved between devices; median
  std::string took;      ///< the way of the last picture: what "chosen" chose
};
struct TimeWish {
  std::vector<Canvas> canvases;
  std::vector<double> targets;
  std::uint32_t repeats = 7;
  double warm_up = 1;   ///< seconds
  double longest = 60;  ///< of one picture
  std::function<void(const TimeRow&)> each;
};
/// With one device and with all of `devices`, whose copies of the volume are given up first.
Result<std::vector<TimeRow>> measure_times(ManyDevices devices, const volume::Volume& volume,
                                           const diaphane::v1::Scene& scene, const TimeWish& wish);

}  // namespace diaphane::render::bench
