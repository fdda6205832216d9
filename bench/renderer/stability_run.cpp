// Long runs, and interrupted runs.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "bench/renderer/stability_case.h"

namespace diaphane::render::bench {
namespace {

using Clock = std::chrono::steady_clock;

/// Renders a sparse signal: one sample in 1000 is 1. An fp32 running mean would be 2.4% off.
void many_samples(Engine& engine, const StabilityOptions& options, StabilityRow& row) {
  const volume::Volume v = test::constant_volume(8, 100);
  diaphane::v1::Scene scene = beam({20, 15, 10}, {0, 0, 0}, 1e-3);
  const double length = length_inside(v.header, {20, 15, 10}, {0, 0, 0});
  set_medium(scene, {{0, 1}, {200, 1}}, std::log(1000.0) / length);
  const std::uint32_t samples = options.quick ? 1'000'000 : 12'000'000;
  const ImageStats stats = image_stats(engine, v, scene, {2, 2}, samples, row);
  if (!stats.refused.empty()) return;
  // Four pixels are too few to measure their own spread, but that of a binary value is known. An
  // engine that computes the transmittance without random numbers is closer still.
  const double expected = 1e-3;
  const double sigma = std::sqrt(expected * (1 - expected) / row.samples);
  const double off = std::max(std::abs(stats.mean - expected) - kRounding * expected, 0.0);
  note_deviation(off / sigma, kMostSigmas, "sigma", row);
}

/// Returns the time from the moment `stop` first returns true until render() returns.
double stop_takes(ProgressiveRenderer& renderer, double after_seconds, std::uint32_t samples,
                  StabilityRow& row) {
  const auto begin = Clock::now();
  auto asked = Clock::time_point::max();
  auto batch = renderer.render(samples, [&] {
    const auto now = Clock::now();
    if (now - begin < std::chrono::duration<double>(after_seconds)) return false;
    asked = std::min(asked, now);
    return true;
  });
  const auto end = Clock::now();
  if (!batch) {
    row.passed = false;
    row.note = batch.error().message;
    return 0;
  }
  row.non_finite += batch->dropped_samples;
  row.samples += batch->samples;
  return asked == Clock::time_point::max()
             ? 0.0
             : std::chrono::duration<double, std::milli>(end - asked).count();
}

/// Stops paths of a thousand collisions in dense matter on a large canvas, which would take minutes
/// per sample in a single launch. The limit is generous, because the machine may be busy.
void stopped(Engine& engine, const StabilityOptions&, StabilityRow& row) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.mutable_transfer_function()->set_extinction_per_mm(1e4);
  test::set(scene.mutable_transfer_function()->mutable_channels(0)->mutable_diffuse(), 1, 1, 1);
  scene.set_bounces(1024);
  const Canvas canvas{2048, 2048};
  auto loaded = engine.load(test::skull_volume());
  auto renderer = loaded ? engine.renderer(*loaded, 1, 0)
                         : Result<std::unique_ptr<FrameRenderer>>(tl::unexpect, loaded.error());
  if (!renderer || !(*renderer)->set_scene(scene, canvas)) {
    row.passed = false;
    row.note = "there is no picture to stop";
    return;
  }
  std::string each;
  for (const double after : {0.0, 0.01, 0.2, 1.0}) {
    const double ms = stop_takes(**renderer, after, 1 << 20, row);
    note_deviation(ms, engine.info().engine == "cuda" ? 100 : 2000, "ms", row);
    each += (each.empty() ? "" : ", ") + std::to_string(std::lround(ms));
  }
  row.samples *= double{1} * canvas.width * canvas.height;
  row.note =
      "from when stop says so, after 0, 10, 200 and 1000 ms, to the return of render(): " + each;
}

}  // namespace

std::vector<StabilityCase> run_cases() {
  return {{"1.2e7 samples of a sparse signal (fp64 fold)", many_samples},
          {"a picture of minutes, stopped", stopped}};
}

}  // namespace diaphane::render::bench
