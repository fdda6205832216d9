#include "renderd/bench/growth.h"

#include <algorithm>
#include <ctime>

#include "renderd/bench/made_volume.h"
#include "renderd/bench/timing.h"

namespace diaphane::render::bench {
namespace {

const std::function<bool()> kOnAndOn = [] { return false; };

/// Milliseconds of one call that may fail.
template <typename Call>
Result<double> timed(const Call& call) {
  const auto begin = Clock::now();
  if (auto done = call(); !done) return tl::unexpected(done.error());
  return seconds_since(begin) * 1e3;
}

template <typename Call>
Result<Timing> timed(std::uint32_t repeats, const Call& call) {
  std::vector<double> runs;
  for (std::uint32_t i = 0; i < repeats; ++i) {
    const auto one = call(i);
    if (!one) return tl::unexpected(one.error());
    runs.push_back(*one);
  }
  return Timing{median_of(runs), deviation_of(runs)};
}

/// `samples` from an empty film.
Result<double> shoot(FrameRenderer& renderer, const diaphane::v1::Scene& scene, Canvas canvas,
                     std::uint32_t samples) {
  if (auto set = renderer.set_scene(scene, canvas); !set) return tl::unexpected(set.error());
  return timed([&] { return renderer.render(samples, kOnAndOn); });
}

/// Another transfer function that shows the same: its tables, bounds and structures are made anew.
diaphane::v1::Scene edited(diaphane::v1::Scene scene, std::uint32_t i) {
  auto* function = scene.mutable_transfer_function();
  function->set_extinction_per_mm(function->extinction_per_mm() * (1 + 1e-4 * (i + 1)));
  return scene;
}

/// Kernels are compiled, threads and the device awake: by a small volume, so that nothing of the
/// measured ones is there before its time.
Result<void> wake(Engine& engine, const GrowthWish& wish) {
  const auto volume = engine.load(made_volume(64));
  if (!volume) return tl::unexpected(volume.error());
  for (const Walk walk : wish.walks) {
    const auto renderer = engine.renderer(*volume, 1, 0, {.walk = walk});
    if (!renderer) return tl::unexpected(renderer.error());
    for (int i = 0; i < 3; ++i) {
      const auto shot = shoot(**renderer, wish.scene, {64, 64}, 1);
      if (!shot && shot.error().code == ErrorCode::kUnsupported) break;
      if (!shot) return tl::unexpected(shot.error());
    }
  }
  return {};
}

Result<void> measure_points(FrameRenderer& renderer, const GrowthWish& wish, GrowthRow& row) {
  const auto begin = Clock::now();
  Curve curve;
  // Two points at least: what is between them, or behind them, follows from their slope.
  for (std::uint32_t n = 2; n <= std::max(wish.most, 4u); n *= 2) {
    CurvePoint point;
    point.samples = n;
    std::vector<double> runs;
    do {
      const auto shot = shoot(renderer, wish.scene, row.canvas, n);
      if (!shot) return tl::unexpected(shot.error());
      runs.push_back(*shot);
    } while (runs.size() < wish.repeats && seconds_since(begin) < wish.seconds / 4);
    point.milliseconds = median_of(runs);
    point.milliseconds_spread = deviation_of(runs);
    point.estimate = renderer.progress().error;
    curve.points.push_back(point);
    if (point.estimate <= wish.target) break;
    if (curve.points.size() > 1 && seconds_since(begin) > wish.seconds) break;
  }
  row.points = curve.points;
  row.in_a_row = row.points.back().milliseconds / row.points.back().samples;
  row.to_target = crossing(curve, wish.target, &CurvePoint::estimate);
  // Two times, of which one was disturbed, say little of a third.
  if (row.to_target && row.to_target->how == Crossing::How::kProlonged) {
    row.to_target->milliseconds = row.to_target->samples * row.in_a_row;
  }
  return {};
}

Result<void> measure_row(Engine& engine, const std::shared_ptr<const DeviceVolume>& volume,
                         const GrowthWish& wish, GrowthRow& row) {
  const auto made = engine.renderer(volume, 1, 0, {.walk = row.walk});
  if (!made) return tl::unexpected(made.error());
  FrameRenderer& renderer = **made;
  const auto prepare = timed([&] { return renderer.set_scene(wish.scene, row.canvas); });
  if (!prepare) return tl::unexpected(prepare.error());
  row.prepare = *prepare;
  const auto edit = timed(wish.repeats, [&](std::uint32_t i) {
    const diaphane::v1::Scene scene = edited(wish.scene, i);
    return timed([&] { return renderer.set_scene(scene, row.canvas); });
  });
  if (!edit) return tl::unexpected(edit.error());
  row.edit = *edit;
  if (auto warm = shoot(renderer, wish.scene, row.canvas, 1); !warm) {
    return tl::unexpected(warm.error());
  }
  std::vector<double> processors;
  const auto pass = timed(wish.repeats, [&](std::uint32_t) {
    if (auto set = renderer.set_scene(wish.scene, row.canvas); !set) {
      return Result<double>(tl::unexpected(set.error()));
    }
    const std::clock_t before = std::clock();
    auto one = timed([&] { return renderer.render(1, kOnAndOn); });
    processors.push_back(1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
    return one;
  });
  if (!pass) return tl::unexpected(pass.error());
  row.pass = *pass;
  row.processors = median_of(processors);
  if (auto points = measure_points(renderer, wish, row); !points) return points;
  const KernelReport report = renderer.report();
  row.volume_bytes = report.volume_bytes;
  row.acceleration_bytes = report.acceleration_bytes;
  row.film_bytes = report.film_bytes;
  return {};
}

}  // namespace

Result<std::vector<GrowthRow>> measure_growth(Engine& engine,
                                              const std::vector<GrowthSubject>& subjects,
                                              const GrowthWish& wish) {
  if (auto awake = wake(engine, wish); !awake) return tl::unexpected(awake.error());
  std::vector<GrowthRow> rows;
  for (const GrowthSubject& subject : subjects) {
    auto volume = subject.make();
    if (!volume) return tl::unexpected(volume.error());
    const auto begin = Clock::now();
    const auto loaded = engine.load(*volume);
    if (!loaded) return tl::unexpected(loaded.error());
    const double load = seconds_since(begin) * 1e3;
    volume->voxels = {};
    for (const Canvas canvas : subject.canvases) {
      for (const Walk walk : wish.walks) {
        GrowthRow row;
        row.volume = subject.name;
        row.size = volume->header.size;
        row.canvas = canvas;
        row.walk = walk;
        row.load = load;
        if (auto done = measure_row(engine, *loaded, wish, row); !done) {
          if (done.error().code != ErrorCode::kUnsupported) return tl::unexpected(done.error());
          row.left_out = done.error().message;
        }
        if (wish.each) wish.each(row);
        rows.push_back(std::move(row));
      }
    }
  }
  return rows;
}

}  // namespace diaphane::render::bench
