#include "bench/renderer/growth.h"

#include <algorithm>
#include <ctime>

#include "bench/renderer/synthetic_volume.h"
#include "bench/renderer/timing.h"
#include "common/try.h"

namespace diaphane::render::bench {
namespace {

const std::function<bool()> kOnAndOn = [] { return false; };

/// Returns the milliseconds of one call that may fail.
template <typename Call>
Result<double> timed(const Call& call) {
  const auto begin = Clock::now();
  DIAPHANE_TRY(call());
  return seconds_since(begin) * 1e3;
}

template <typename Call>
Result<Timing> timed(std::uint32_t repeats, const Call& call) {
  std::vector<double> runs;
  for (std::uint32_t i = 0; i < repeats; ++i) {
    const auto one = call(i);
    DIAPHANE_TRY(one);
    runs.push_back(*one);
  }
  return Timing{median_of(runs), deviation_of(runs)};
}

/// Renders `samples` from an empty film. Returns the milliseconds.
Result<double> shoot(ProgressiveRenderer& renderer, const diaphane::v1::Scene& scene, Canvas canvas,
                     std::uint32_t samples) {
  DIAPHANE_TRY(renderer.set_scene(scene, canvas));
  return timed([&] { return renderer.render(samples, kOnAndOn); });
}

/// Returns an equivalent scene with another transfer function, so that its tables, bounds and
/// structures are rebuilt.
diaphane::v1::Scene edited(diaphane::v1::Scene scene, std::uint32_t i) {
  auto* function = scene.mutable_transfer_function();
  function->set_extinction_per_mm(function->extinction_per_mm() * (1 + 1e-4 * (i + 1)));
  return scene;
}

/// Compiles kernels and wakes threads and the device with a small volume, so that nothing of the
/// measured volumes is prepared early.
Result<void> wake(Engine& engine, const GrowthOptions& options) {
  const auto volume = engine.load(synthetic_volume(64));
  DIAPHANE_TRY(volume);
  for (const Walk walk : options.walks) {
    const auto renderer = engine.renderer(*volume, 1, 0, {.walk = walk});
    DIAPHANE_TRY(renderer);
    for (int i = 0; i < 3; ++i) {
      const auto shot = shoot(**renderer, options.scene, {64, 64}, 1);
      if (!shot && shot.error().code == ErrorCode::kUnsupported) break;
      DIAPHANE_TRY(shot);
    }
  }
  return {};
}

Result<void> measure_points(ProgressiveRenderer& renderer, const GrowthOptions& options,
                            GrowthRow& row) {
  const auto begin = Clock::now();
  Curve curve;
  // At least two points, because values between or beyond them follow from their slope.
  for (std::uint32_t n = 2; n <= std::max(options.most, 4u); n *= 2) {
    CurvePoint point;
    point.samples = n;
    std::vector<double> runs;
    do {
      const auto shot = shoot(renderer, options.scene, row.canvas, n);
      DIAPHANE_TRY(shot);
      runs.push_back(*shot);
    } while (runs.size() < options.repeats && seconds_since(begin) < options.seconds / 4);
    point.milliseconds = median_of(runs);
    point.milliseconds_spread = deviation_of(runs);
    point.estimate = renderer.progress().error;
    curve.points.push_back(point);
    if (point.estimate <= options.target) break;
    if (curve.points.size() > 1 && seconds_since(begin) > options.seconds) break;
  }
  row.points = curve.points;
  row.in_a_row = row.points.back().milliseconds / row.points.back().samples;
  row.to_target = crossing(curve, options.target, &CurvePoint::estimate);
  // With two times, of which one may be disturbed, an extrapolated time is unreliable.
  if (row.to_target && row.to_target->how == Crossing::How::kProlonged) {
    row.to_target->milliseconds = row.to_target->samples * row.in_a_row;
  }
  return {};
}

Result<void> measure_row(Engine& engine, const std::shared_ptr<const DeviceVolume>& volume,
                         const GrowthOptions& options, GrowthRow& row) {
  const auto made = engine.renderer(volume, 1, 0, {.walk = row.walk});
  DIAPHANE_TRY(made);
  FrameRenderer& renderer = **made;
  const auto prepare = timed([&] { return renderer.set_scene(options.scene, row.canvas); });
  DIAPHANE_TRY(prepare);
  row.prepare = *prepare;
  const auto edit = timed(options.repeats, [&](std::uint32_t i) {
    const diaphane::v1::Scene scene = edited(options.scene, i);
    return timed([&] { return renderer.set_scene(scene, row.canvas); });
  });
  DIAPHANE_TRY(edit);
  row.edit = *edit;
  DIAPHANE_TRY(shoot(renderer, options.scene, row.canvas, 1));
  std::vector<double> processors;
  const auto pass = timed(options.repeats, [&](std::uint32_t) {
    if (auto set = renderer.set_scene(options.scene, row.canvas); !set) {
      return Result<double>(tl::unexpected(set.error()));
    }
    const std::clock_t before = std::clock();
    auto one = timed([&] { return renderer.render(1, kOnAndOn); });
    processors.push_back(1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
    return one;
  });
  DIAPHANE_TRY(pass);
  row.pass = *pass;
  row.processors = median_of(processors);
  if (auto points = measure_points(renderer, options, row); !points) return points;
  const KernelReport report = renderer.report();
  row.volume_bytes = report.volume_bytes;
  row.acceleration_bytes = report.acceleration_bytes;
  row.film_bytes = report.film_bytes;
  return {};
}

}  // namespace

Result<std::vector<GrowthRow>> measure_growth(Engine& engine,
                                              const std::vector<GrowthSubject>& subjects,
                                              const GrowthOptions& options) {
  DIAPHANE_TRY(wake(engine, options));
  std::vector<GrowthRow> rows;
  for (const GrowthSubject& subject : subjects) {
    auto volume = subject.make();
    DIAPHANE_TRY(volume);
    const auto begin = Clock::now();
    const auto loaded = engine.load(*volume);
    DIAPHANE_TRY(loaded);
    const double load = seconds_since(begin) * 1e3;
    volume->voxels = {};
    for (const Canvas canvas : subject.canvases) {
      for (const Walk walk : options.walks) {
        GrowthRow row;
        row.volume = subject.name;
        row.size = volume->header.size;
        row.canvas = canvas;
        row.walk = walk;
        row.load = load;
        if (auto done = measure_row(engine, *loaded, options, row); !done) {
          if (done.error().code != ErrorCode::kUnsupported) return tl::unexpected(done.error());
          row.left_out = done.error().message;
        }
        if (options.each) options.each(row);
        rows.push_back(std::move(row));
      }
    }
  }
  return rows;
}

}  // namespace diaphane::render::bench
