#include "bench/renderer/play_phases.h"

#include <algorithm>

#include "bench/renderer/synthetic_heart.h"
#include "bench/renderer/text.h"
#include "bench/renderer/timing.h"
#include "common/try.h"
#include "renderd/kernel/method.h"
#include "renderd/scene/framing.h"
#include "renderd/scene/presets.h"

namespace diaphane::render::bench {
namespace {

using Handle = std::shared_ptr<const DeviceVolume>;

/// The phases on a device, and the scene that shows them.
struct Heart {
  std::vector<Handle> phases;
  diaphane::v1::Scene scene;
};

Result<Heart> load_heart(Engine& engine, const PlayOptions& options) {
  const volume::Volume all = synthetic_heart(options.cube, options.phases);
  volume::Volume one;
  one.header = all.header;
  Heart heart;
  for (std::uint32_t phase = 0; phase < options.phases; ++phase) {
    const auto begin =
        all.voxels.begin() + static_cast<std::ptrdiff_t>(phase * all.header.voxel_count());
    one.voxels.assign(begin, begin + static_cast<std::ptrdiff_t>(all.header.voxel_count()));
    one.phase = phase;
    auto loaded = engine.load(one);
    DIAPHANE_TRY(loaded);
    heart.phases.push_back(std::move(*loaded));
  }
  auto preset = preset_for(one.header, visible_part(one), options.preset);
  DIAPHANE_TRY(preset);
  heart.scene = preset->scene();
  return heart;
}

struct Shown {
  double prepare = 0, whole = 0;  ///< ms
};

Result<Shown> show(FrameRenderer& renderer, Heart& heart, std::uint32_t phase, Canvas canvas) {
  const auto begin = Clock::now();
  heart.scene.set_volume_phase(phase);
  DIAPHANE_TRY(renderer.set_volume(heart.phases[phase]));
  DIAPHANE_TRY(renderer.set_scene(heart.scene, canvas));
  Shown shown;
  shown.prepare = 1e3 * seconds_since(begin);
  const auto batch = renderer.render(1, [] { return false; });
  DIAPHANE_TRY(batch);
  PictureRgb8 picture;
  DIAPHANE_TRY(renderer.display_denoised(picture));
  shown.whole = 1e3 * seconds_since(begin);
  return shown;
}

}  // namespace

Result<PlayReport> play_phases(Engine& engine, const PlayOptions& options) {
  PlayReport report;
  const auto loading = Clock::now();
  auto heart = load_heart(engine, options);
  DIAPHANE_TRY(heart);
  report.load = seconds_since(loading);
  for (const Handle& phase : heart->phases) report.bytes += phase->device_bytes();
  auto renderer = engine.renderer(heart->phases.front(), 1, 0, kLiveMethod);
  DIAPHANE_TRY(renderer);
  (*renderer)->prepare_denoising(true);

  std::vector<double> first, prepare, whole;
  for (std::uint32_t phase = 0; phase < options.phases; ++phase) {
    const auto shown = show(**renderer, *heart, phase, options.canvas);
    DIAPHANE_TRY(shown);
    first.push_back(shown->prepare);
  }
  const auto begin = Clock::now();
  while (whole.size() < options.phases || seconds_since(begin) < options.seconds) {
    const auto phase = static_cast<std::uint32_t>(whole.size() % options.phases);
    const auto shown = show(**renderer, *heart, phase, options.canvas);
    DIAPHANE_TRY(shown);
    prepare.push_back(shown->prepare);
    whole.push_back(shown->whole);
  }
  report.per_second = static_cast<double>(whole.size()) / seconds_since(begin);
  report.first_prepare = median_of(first);
  report.prepare = median_of(prepare);
  report.picture = median_of(whole);
  std::sort(whole.begin(), whole.end());
  report.slowest = whole[whole.size() * 95 / 100];
  return report;
}

std::string play_text(const PlayReport& r, const EngineInfo& info, const PlayOptions& options) {
  std::string text;
  print(text, "%u phases of %u^3 at %u x %u on ", options.phases, options.cube,
        options.canvas.width, options.canvas.height);
  text += info.device;
  print(text, "\nloaded in %.1f s, %.0f MB\n", r.load, static_cast<double>(r.bytes) / 1e6);
  print(text, "prepare: %.1f ms for the first time, then %.1f ms\n", r.first_prepare, r.prepare);
  print(text, "picture: %.1f ms, 95%% within %.1f ms\n%.1f phases per second\n", r.picture,
        r.slowest, r.per_second);
  return text;
}

std::string play_json(const PlayReport& r, const EngineInfo& info, const PlayOptions& options) {
  std::string text;
  print(text, "{\"engine\": \"%s\", \"cube\": %u, \"phases\": %u, \"width\": %u, \"height\": %u,\n",
        info.engine.c_str(), options.cube, options.phases, options.canvas.width,
        options.canvas.height);
  print(text, " \"load_s\": %.3f, \"bytes\": %llu, \"first_prepare_ms\": %.3f,\n", r.load,
        static_cast<unsigned long long>(r.bytes), r.first_prepare);
  print(text, " \"prepare_ms\": %.3f, \"picture_ms\": %.3f, \"slowest_ms\": %.3f,\n", r.prepare,
        r.picture, r.slowest);
  print(text, " \"per_second\": %.3f}\n", r.per_second);
  return text;
}

}  // namespace diaphane::render::bench
