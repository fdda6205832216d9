#include <algorithm>
#include <cmath>

#include "bench/renderer/multi_device_bench.h"
#include "bench/renderer/timing.h"
#include "common/try.h"
#include "renderd/composite/composite_engine.h"

namespace diaphane::render::bench {
namespace {

/// The quantum that the scheduler gives to a session that is alone.
constexpr double kQuantumSeconds = 0.005;

struct Shot {
  double milliseconds = 0, first = 0, samples = 0, megabytes = 0;
};

struct Way {
  const char* name;
  unsigned devices;
  std::optional<Division> division;
};

/// An engine that is only borrowed, because the engines outlive each composite of them.
class Borrowed final : public Engine {
 public:
  explicit Borrowed(Engine& engine) : engine_(engine) {}
  EngineInfo info() const override { return engine_.info(); }
  Result<std::shared_ptr<const DeviceVolume>> load(const volume::Volume& volume) override {
    return engine_.load(volume);
  }

 private:
  Result<std::unique_ptr<FrameRenderer>> make_renderer(std::shared_ptr<const DeviceVolume> volume,
                                                       std::uint64_t seed,
                                                       std::uint64_t first_sample,
                                                       Method method) override {
    return engine_.renderer(std::move(volume), seed, first_sample, method);
  }
  Engine& engine_;
};

Result<Shot> shoot(ProgressiveRenderer& renderer, const diaphane::v1::Scene& scene, Canvas canvas,
                   double target, double longest) {
  Shot shot;
  double per_sample = 0;
  const auto begin = Clock::now();
  DIAPHANE_TRY(renderer.set_scene(scene, canvas));
  for (;;) {
    const double fitting = per_sample > 0 ? kQuantumSeconds / per_sample : 1;
    const auto batch = renderer.render(static_cast<std::uint32_t>(std::clamp(fitting, 1.0, 1024.0)),
                                       [] { return false; });
    DIAPHANE_TRY(batch);
    if (batch->samples > 0) per_sample = batch->seconds / batch->samples;
    const Progress progress = renderer.progress();
    if (shot.first == 0 && progress.samples > 0) shot.first = seconds_since(begin) * 1e3;
    shot.samples = static_cast<double>(progress.samples);
    if (progress.error <= target || seconds_since(begin) > longest) break;
  }
  shot.milliseconds = seconds_since(begin) * 1e3;
  if (const auto* many = dynamic_cast<const CompositeRenderer*>(&renderer)) {
    shot.megabytes = static_cast<double>(many->composite().bytes) / 1e6;
  }
  return shot;
}

TimeRow summarise(const std::vector<Shot>& shots) {
  TimeRow row;
  std::vector<double> milliseconds, first, samples, megabytes;
  for (const Shot& shot : shots) {
    milliseconds.push_back(shot.milliseconds);
    first.push_back(shot.first);
    samples.push_back(shot.samples);
    megabytes.push_back(shot.megabytes);
  }
  row.milliseconds = median_of(milliseconds);
  row.spread = deviation_of(milliseconds);
  row.first = median_of(first);
  row.samples = median_of(samples);
  row.megabytes = median_of(megabytes);
  return row;
}

}  // namespace

Result<std::vector<TimeRow>> measure_times(DeviceSet devices, const volume::Volume& volume,
                                           const diaphane::v1::Scene& scene,
                                           const TimeOptions& options) {
  const auto all = static_cast<unsigned>(devices.engines.size());
  devices.volumes.clear();
  const Way ways[] = {{"one", 1, Division::kAverage},
                      {"averaging", all, Division::kAverage},
                      {"tiles", all, Division::kTiles},
                      {"chosen", all, std::nullopt}};
  if (options.targets.empty()) return std::vector<TimeRow>{};
  const double furthest = std::ranges::min(options.targets);
  std::vector<TimeRow> rows;
  for (const Way& way : ways) {
    std::vector<std::unique_ptr<Engine>> borrowed;
    for (unsigned d = 0; d < way.devices; ++d) {
      borrowed.push_back(std::make_unique<Borrowed>(*devices.engines[d]));
    }
    const auto engine =
        make_composite_engine(std::move(borrowed), nullptr, {.division = way.division});
    const auto loaded = engine->load(volume);
    DIAPHANE_TRY(loaded);
    for (const Canvas canvas : options.canvases) {
      for (const double target : options.targets) {
        // The renderer learns speeds and the cost of rows from earlier pictures, as in a session.
        // If a picture ended with its first pair of samples, no part would ever arrive.
        const auto renderer = engine->renderer(*loaded, 1, 0, kLiveMethod);
        DIAPHANE_TRY(renderer);
        (*renderer)->prepare_denoising(options.smoothed);
        const auto begin = Clock::now();
        int shown = 0;
        do {
          const auto warm = shoot(**renderer, scene, canvas, furthest, options.longest);
          DIAPHANE_TRY(warm);
        } while (++shown < 3 || seconds_since(begin) < options.warm_up);
        std::vector<Shot> shots;
        for (std::uint32_t repeat = 0; repeat < options.repeats; ++repeat) {
          const auto shot = shoot(**renderer, scene, canvas, target, options.longest);
          DIAPHANE_TRY(shot);
          shots.push_back(*shot);
        }
        TimeRow row = summarise(shots);
        row.division = way.name;
        row.canvas = canvas;
        row.target = target;
        if (const auto* many = dynamic_cast<const CompositeRenderer*>(renderer->get())) {
          row.took = many->composite().division == Division::kTiles ? "tiles" : "averaging";
        }
        if (options.each) options.each(row);
        rows.push_back(std::move(row));
      }
    }
  }
  return rows;
}

}  // namespace diaphane::render::bench
