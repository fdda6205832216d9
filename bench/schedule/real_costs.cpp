#include <algorithm>
#include <cmath>

#include "bench/renderer/timing.h"
#include "bench/schedule/real_run.h"
#include "common/try.h"

namespace diaphane::render::bench {
namespace {

const auto kNever = [] { return false; };

/// Returns the median seconds of several calls, or the first error.
template <typename Call>
Result<double> timed(int times, Call call) {
  std::vector<double> seconds;
  for (int i = 0; i < times; ++i) {
    const auto start = Clock::now();
    DIAPHANE_TRY(call(i));
    seconds.push_back(seconds_since(start));
  }
  return median_of(std::move(seconds));
}

v1::Scene turned(v1::Scene scene, int step) {
  auto& eye = *scene.mutable_camera()->mutable_eye();
  eye.set_x(eye.x() + 0.5 * std::sin(0.1 * step));
  return scene;
}

constexpr double kLeastSeconds = 0.3;

Result<SceneCost> scene_cost(ProgressiveRenderer& renderer, const v1::Scene& scene, Canvas canvas) {
  DIAPHANE_TRY(renderer.set_scene(scene, canvas));
  // The error after the first samples determines the cost of a good picture.
  DIAPHANE_TRY(renderer.render(2, kNever));
  const double noise = renderer.progress().error * std::sqrt(2.0);
  double seconds = 0;
  std::uint64_t samples = 0;
  while (seconds < kLeastSeconds) {
    const auto batch = renderer.render(16, kNever);
    DIAPHANE_TRY(batch);
    seconds += batch->seconds;
    samples += batch->samples;
  }
  return SceneCost{seconds / (double(samples) * canvas.width * canvas.height), noise};
}

}  // namespace

Canvas scaled(Canvas viewport, double scale) {
  const auto side = [scale](std::uint32_t length) {
    return std::max(16U, static_cast<std::uint32_t>(std::lround(length * scale / 2)) * 2);
  };
  return {side(viewport.width), side(viewport.height)};
}

Result<DeviceModel> measure_costs(const Stage& stage, double scale) {
  DeviceModel model;
  model.name = stage.engine.info().device;
  model.parallel = stage.engine.info().parallel;
  model.queues = stage.engine.info().queues;
  model.look_seconds = 0.3e-6;
  auto renderer = stage.engine.renderer(stage.volume, 1, 0, kLiveMethod);
  DIAPHANE_TRY(renderer);
  FrameRenderer& r = **renderer;
  r.prepare_denoising(true);
  const Canvas large = scaled({512, 512}, scale), small = scaled({256, 256}, scale);
  for (const auto& [name, scene] : stage.scenes) {
    const auto cost = scene_cost(r, scene, large);
    DIAPHANE_TRY(cost);
    model.scenes[name] = *cost;
  }
  const v1::Scene& scene = stage.scenes.begin()->second;
  const auto scenes = timed(15, [&](int i) { return r.set_scene(turned(scene, i), large); });
  DIAPHANE_TRY(scenes);
  model.scene_seconds = *scenes;
  // Compares quanta of one sample each with a single quantum of all samples.
  constexpr int kQuanta = 32;
  DIAPHANE_TRY(r.render(2, kNever));
  const auto one = timed(kQuanta, [&](int) {
    auto batch = r.render(1, kNever);
    (void)r.progress();
    return batch;
  });
  const auto all = timed(5, [&](int) { return r.render(kQuanta, kNever); });
  if (!one || !all) return tl::unexpected(one ? all.error() : one.error());
  model.quantum_seconds = std::max(0.0, *one - *all / kQuanta);
  // Measures the first picture of an epoch, which is smoothed and thus the most expensive.
  double seconds[2] = {};
  const Canvas sizes[2] = {small, large};
  for (int i = 0; i < 2; ++i) {
    PictureRgb8 picture;
    DIAPHANE_TRY(r.set_scene(scene, sizes[i]));
    DIAPHANE_TRY(r.render(2, kNever));
    const auto shown = timed(9, [&](int) { return r.display_denoised(picture); });
    DIAPHANE_TRY(shown);
    seconds[i] = *shown;
  }
  const auto pixels = [](Canvas c) { return double(c.width) * c.height; };
  model.picture_seconds_per_pixel =
      std::max(0.0, (seconds[1] - seconds[0]) / (pixels(large) - pixels(small)));
  model.picture_seconds =
      std::max(0.0, seconds[0] - model.picture_seconds_per_pixel * pixels(small));
  return model;
}

}  // namespace diaphane::render::bench
