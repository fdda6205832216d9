#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "renderd/bench/convergence.h"

// How cost grows with the volume and with the picture: one scene on volumes of several sizes at one
// canvas, and on one volume at several canvases, by each choice of the walk.

namespace diaphane::render::bench {

/// A volume, made only when its turn comes (1024^3 takes 2 GB), and the canvases to see it on.
struct GrowthSubject {
  std::string name;
  std::function<Result<volume::Volume>()> make;
  std::vector<Canvas> canvases;
};

/// Milliseconds: the median of several runs and their standard deviation.
struct Timing {
  double median = 0;
  double spread = 0;
};

struct GrowthRow {
  std::string volume;
  std::array<std::uint32_t, 3> size{};  ///< voxels
  Canvas canvas;
  Walk walk = Walk::kAuto;
  std::optional<std::string>
      left_out;        ///< why there are no figures: the choice does not exist here
  double load = 0;     ///< ms, once a volume: copy and ranges of values of its cells
  double prepare = 0;  ///< ms: the first scene on it, every structure made, kernels compiled before
  Timing edit;         ///< set_scene with another transfer function
  Timing pass;         ///< one sample a pixel from an empty film, by a call of its own
  double processors = 0;  ///< ms of all processors together in a pass, median: on a busy machine
  double in_a_row = 0;    ///< ms a pass in the last of `points`
  std::vector<CurvePoint> points;     ///< 2, 4, 8 ... samples; only estimate and milliseconds
  std::optional<Crossing> to_target;  ///< by the estimate; kFirst: two samples have less
  std::uint64_t volume_bytes = 0, acceleration_bytes = 0, film_bytes = 0;  ///< as the engine says
};

struct GrowthWish {
  diaphane::v1::Scene scene;
  std::vector<Walk> walks{Walk::kExact, Walk::kTracking};
  std::uint32_t repeats = 5;
  double target = 0.05;       ///< estimated error to which the time is given
  std::uint32_t most = 1024;  ///< samples of the last point at most
  /// After so long in one row's points no further one is begun; after a quarter none is repeated.
  double seconds = 30;
  std::function<void(const GrowthRow&)> each;  ///< as soon as it is measured
};

Result<std::vector<GrowthRow>> measure_growth(Engine& engine,
                                              const std::vector<GrowthSubject>& subjects,
                                              const GrowthWish& wish);

std::string growth_heading();
std::string growth_text(const GrowthRow& row);
std::string growth_csv(const std::vector<GrowthRow>& rows, const std::string& engine);
std::string growth_json(const std::vector<GrowthRow>& rows, const EngineInfo& info,
                        const GrowthWish& wish);

}  // namespace diaphane::render::bench
