#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/renderer/convergence.h"

// How cost grows with the volume and the picture: one scene on volumes of several sizes at one
// canvas, and on one volume at several canvases, for each choice of the walk.

namespace diaphane::render::bench {

/// A volume that is created only when it is needed (1024^3 takes 2 GB), and the canvases to render
/// it on.
struct GrowthSubject {
  std::string name;
  std::function<Result<volume::Volume>()> make;
  std::vector<Canvas> canvases;
};

/// Median and standard deviation of several runs, in milliseconds.
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
      left_out;     ///< why there are no figures: the method does not exist here
  double load = 0;  ///< ms, once per volume: copying it and computing the value ranges of its cells
  double prepare = 0;  ///< ms for the first scene, including all structures but not compilation
  Timing edit;         ///< set_scene with another transfer function
  Timing pass;         ///< one sample per pixel from an empty film, in one call
  /// Median CPU time of all cores per pass in ms, which is meaningful on a busy machine.
  double processors = 0;
  double in_a_row = 0;                ///< ms per pass in the last of `points`
  std::vector<CurvePoint> points;     ///< 2, 4, 8 ... samples, with only estimate and milliseconds
  std::optional<Crossing> to_target;  ///< by the estimate; kFirst: two samples are already below
  /// Memory that the engine reports.
  std::uint64_t volume_bytes = 0, acceleration_bytes = 0, film_bytes = 0;
};

struct GrowthOptions {
  diaphane::v1::Scene scene;
  std::vector<Walk> walks{Walk::kExact, Walk::kTracking};
  std::uint32_t repeats = 5;
  double target = 0.05;       ///< estimated error for which the time is given
  std::uint32_t most = 1024;  ///< maximum samples of the last point
  /// Time limit for the points of one row, after which no further one begins. After a quarter of
  /// it, none is repeated.
  double seconds = 30;
  std::function<void(const GrowthRow&)> each;  ///< called for each row after its measurement
};

Result<std::vector<GrowthRow>> measure_growth(Engine& engine,
                                              const std::vector<GrowthSubject>& subjects,
                                              const GrowthOptions& options);

std::string growth_heading();
std::string growth_text(const GrowthRow& row);
std::string growth_csv(const std::vector<GrowthRow>& rows, const std::string& engine);
std::string growth_json(const std::vector<GrowthRow>& rows, const EngineInfo& info,
                        const GrowthOptions& options);

}  // namespace diaphane::render::bench
