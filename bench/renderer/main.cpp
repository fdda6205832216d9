// diaphane-renderd-bench measures error against run time (convergence), the growth of cost with
// volume and picture (growth), stiff cases (stability), playing the phases of a scan (phases), the
// scheduler's policies (schedule), and one picture rendered by several devices (many).
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <iostream>

#include "bench/renderer/convergence.h"
#include "bench/renderer/convergence_report.h"
#include "bench/renderer/growth.h"
#include "bench/renderer/multi_device_command.h"
#include "bench/renderer/multi_process_engine.h"
#include "bench/renderer/play_phases.h"
#include "bench/renderer/stability.h"
#include "bench/renderer/synthetic_volume.h"
#include "bench/renderer/text.h"
#include "bench/schedule/schedule_command.h"
#include "common/try.h"
#include "renderd/scene/presets.h"

namespace {

namespace render = diaphane::render;
namespace bench = diaphane::render::bench;
using diaphane::ErrorCode;
using diaphane::Result;

constexpr int kFailed = 65, kNoDevice = 69;  // sysexits.h, as in diaphane-render

struct Options {
  std::string volume = "made", scene, preset, engine = "cpu", size = "512x512";
  unsigned threads = 0, devices = 1;
  std::vector<std::string> walks{"tracking"}, points{"low-discrepancy", "independent"};
  std::vector<std::string> mis{"both"}, roulette{"on"};
  std::string json, csv;
  bool quiet = false;
  bench::ConvergenceOptions convergence;
  bench::ReportHead head;
  bench::StabilityOptions stability;
  bench::GrowthOptions growth;
  bench::PlayOptions play;
  std::vector<std::uint32_t> cubes{256, 512, 1024};
  std::uint32_t canvas_cube = 512;
  std::vector<std::string> canvases{"640x360", "1280x720", "1920x1080", "3840x2160"}, others;
  std::vector<std::string> growth_walks{"exact", "tracking"};
};

int complain(const diaphane::Error& error) {
  std::cerr << "diaphane-renderd-bench: " << (error.field.empty() ? "" : error.field + ": ")
            << error.message << '\n';
  return error.code == ErrorCode::kUnavailable ? kNoDevice : kFailed;
}

Result<diaphane::v1::Scene> scene_of(const std::string& path) {
  const auto text = bench::read_text(path);
  DIAPHANE_TRY(text);
  return render::scene_from_json(*text);
}

Result<render::Canvas> canvas_of(const std::string& text) {
  render::Canvas canvas;
  char end = 0;
  if (std::sscanf(text.c_str(), "%ux%u%c", &canvas.width, &canvas.height, &end) != 2) {
    return diaphane::fail(ErrorCode::kInvalid, "WIDTHxHEIGHT: not '" + text + "'", "--size");
  }
  return canvas;
}

render::Walk walk_of(const std::string& name) {
  return name == "exact"      ? render::Walk::kExact
         : name == "tracking" ? render::Walk::kTracking
                              : render::Walk::kAuto;
}

std::vector<render::Method> methods_of(const Options& options) {
  std::vector<render::Method> methods;
  for (const std::string& walk : options.walks) {
    for (const std::string& points : options.points) {
      for (const std::string& mis : options.mis) {
        for (const std::string& roulette : options.roulette)
          methods.push_back({walk_of(walk), points == "low-discrepancy",
                             mis == "light"     ? render::Mis::kLight
                             : mis == "scatter" ? render::Mis::kScatter
                                                : render::Mis::kBoth,
                             roulette == "on"});
      }
    }
  }
  return methods;
}

/// Returns the last part of a path without its extension.
std::string short_name(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  path = path.substr(path.find_last_of('/') + 1);
  return path.substr(0, path.find_last_of('.'));
}

Result<std::unique_ptr<render::Engine>> engine_of(const Options& options) {
  const auto choice =
      options.engine == "cuda" ? render::EngineChoice::kCuda : render::EngineChoice::kCpu;
  if (options.devices > 1)
    return bench::make_multi_process_engine(choice, options.devices, options.threads);
  return render::make_engine(choice, options.threads);
}

/// Returns the scene file, or the preset fitted to the volume.
Result<diaphane::v1::Scene> subject_of(const Options& options,
                                       const diaphane::volume::Volume& volume) {
  if (options.preset.empty()) return scene_of(options.scene);
  auto preset = render::preset_for(volume.header, render::visible_part(volume), options.preset);
  DIAPHANE_TRY(preset);
  return preset->scene();
}

Result<bench::Convergence> converge(Options& options) {
  auto engine = engine_of(options);
  DIAPHANE_TRY(engine);
  auto volume = bench::named_volume(options.volume);
  DIAPHANE_TRY(volume);
  auto scene = subject_of(options, *volume);
  DIAPHANE_TRY(scene);
  auto canvas = canvas_of(options.size);
  DIAPHANE_TRY(canvas);
  auto loaded = (*engine)->load(*volume);
  DIAPHANE_TRY(loaded);
  options.head.engine = (*engine)->info();
  options.head.volume = short_name(options.volume);
  options.head.scene = options.preset.empty() ? short_name(options.scene) : options.preset;
  options.head.devices = options.devices;
  options.head.repeats = options.convergence.repeats;
  options.convergence.methods = methods_of(options);
  const bool show = !options.quiet && ::isatty(STDERR_FILENO) == 1;
  if (show) options.convergence.say = [](const std::string& words) { std::cerr << words << '\n'; };
  return bench::measure_convergence(
      {engine->get(), *loaded, bench::hash_of(*volume), *scene, *canvas}, options.convergence);
}

int run(Options& options) {
  auto result = converge(options);
  if (!result) return complain(result.error());
  std::cout << bench::report_text(options.head, *result) << std::flush;
  const bool all = bench::written(options.json, bench::report_json(options.head, *result)) &&
                   bench::written(options.csv, bench::report_csv(*result));
  return all ? 0 : kFailed;
}

/// Runs the stiff cases and prints their results. Returns 1 if a case fails.
int run_stability(Options& options) {
  auto engine = engine_of(options);
  if (!engine) return complain(engine.error());
  const render::EngineInfo info = (*engine)->info();
  std::printf("%-52s %-5s %9s %6s %9s %-9s %s\n", "case", "", "samples", "bad", "deviation", "",
              "verdict");
  bool all = true;
  options.stability.each = [&](const bench::StabilityRow& row) {
    std::cout << bench::stability_text(row, info.engine) << std::flush;
    all = all && row.passed;
  };
  const auto rows = bench::measure_stability(**engine, options.stability);
  std::cout << (all ? "all passed" : "some failed") << ": " << rows.size() << " cases on "
            << info.device << '\n';
  if (!bench::written(options.json, bench::stability_json(rows, info)) ||
      !bench::written(options.csv, bench::stability_csv(rows, info.engine))) {
    return kFailed;
  }
  return all ? 0 : 1;
}

/// Returns cubes at one canvas, and one cube and the named volumes at every canvas.
Result<std::vector<bench::GrowthSubject>> subjects_of(const Options& options) {
  auto one = canvas_of(options.size);
  DIAPHANE_TRY(one);
  std::vector<render::Canvas> all;
  for (const std::string& text : options.canvases) {
    auto canvas = canvas_of(text);
    DIAPHANE_TRY(canvas);
    all.push_back(*canvas);
  }
  std::vector<bench::GrowthSubject> subjects;
  std::vector<std::uint32_t> cubes = options.cubes;
  if (options.canvas_cube > 0) cubes.push_back(options.canvas_cube);
  std::sort(cubes.begin(), cubes.end());
  cubes.erase(std::unique(cubes.begin(), cubes.end()), cubes.end());
  for (const std::uint32_t n : cubes) {
    bench::GrowthSubject subject{
        std::to_string(n) + "^3", [n] { return bench::synthetic_cube(n); }, {}};
    if (std::count(options.cubes.begin(), options.cubes.end(), n) > 0) subject.canvases = {*one};
    if (n == options.canvas_cube) {
      subject.canvases.insert(subject.canvases.end(), all.begin(), all.end());
    }
    subjects.push_back(std::move(subject));
  }
  for (const std::string& path : options.others) {
    subjects.push_back({short_name(path), [path] { return bench::named_volume(path); }, all});
  }
  return subjects;
}

int run_growth(Options& options) {
  auto engine = engine_of(options);
  if (!engine) return complain(engine.error());
  auto scene = scene_of(options.scene);
  if (!scene) return complain(scene.error());
  auto subjects = subjects_of(options);
  if (!subjects) return complain(subjects.error());
  const render::EngineInfo info = (*engine)->info();
  bench::GrowthOptions& growth = options.growth;
  growth.scene = *scene;
  growth.walks.clear();
  for (const std::string& walk : options.growth_walks) growth.walks.push_back(walk_of(walk));
  growth.each = [](const bench::GrowthRow& row) {
    std::cout << bench::growth_text(row) << std::flush;
  };
  std::cout << short_name(options.scene) << " on " << info.device << "; times in ms, target "
            << growth.target << " by the estimate; medians of " << growth.repeats << '\n'
            << bench::growth_heading() << std::flush;
  const auto rows = bench::measure_growth(**engine, *subjects, growth);
  if (!rows) return complain(rows.error());
  const bool all = bench::written(options.json, bench::growth_json(*rows, info, growth)) &&
                   bench::written(options.csv, bench::growth_csv(*rows, info.engine));
  return all ? 0 : kFailed;
}

int run_phases(Options& options) {
  auto engine = engine_of(options);
  if (!engine) return complain(engine.error());
  auto canvas = canvas_of(options.size);
  if (!canvas) return complain(canvas.error());
  options.play.canvas = *canvas;
  const auto report = bench::play_phases(**engine, options.play);
  if (!report) return complain(report.error());
  const render::EngineInfo info = (*engine)->info();
  std::cout << bench::play_text(*report, info, options.play) << std::flush;
  const std::string json = bench::play_json(*report, info, options.play);
  return bench::written(options.json, json) ? 0 : kFailed;
}

void add_shared(CLI::App& c, Options& o) {
  c.add_option("--engine", o.engine, "rendering engine")->check(CLI::IsMember({"cpu", "cuda"}));
  c.add_option("--threads", o.threads, "threads of the CPU engine (0 = one per core)");
  c.add_option("--json", o.json, "write the results to this file as JSON");
  c.add_option("--csv", o.csv, "write the results to this file as CSV");
}

CLI::App* add_stability(CLI::App& app, Options& o) {
  auto* c = app.add_subcommand("stability", "Run numerically stiff and extreme cases");
  add_shared(*c, o);
  c->add_flag("--quick", o.stability.quick, "use a tenth of the samples");
  c->add_option("--only", o.stability.only, "only cases whose name contains this text");
  return c;
}

CLI::App* add_phases(CLI::App& app, Options& o) {
  auto* c = app.add_subcommand("phases", "Measure how fast the phases of a beating heart play");
  c->add_option("--engine", o.engine, "rendering engine")->check(CLI::IsMember({"cpu", "cuda"}));
  c->add_option("--threads", o.threads, "threads of the CPU engine (0 = one per core)");
  c->add_option("--json", o.json, "write the results to this file as JSON");
  c->add_option("--cube", o.play.cube, "edge length of the synthetic volume in voxels")
      ->check(CLI::Range(16, 1024));
  c->add_option("--phases", o.play.phases, "number of phases")->check(CLI::Range(2, 1000));
  c->add_option("--size", o.size, "picture size in pixels, WxH");
  c->add_option("--preset", o.play.preset, "built-in look (--list-presets of diaphane-render)");
  c->add_option("--seconds", o.play.seconds, "seconds of playing to measure");
  return c;
}

CLI::App* add_growth(CLI::App& app, Options& o) {
  auto* c = app.add_subcommand(
      "growth", "Measure how the cost grows with the size of the volume and of the picture");
  add_shared(*c, o);
  c->add_option("--scene", o.scene, "scene file (JSON)")->required();
  c->add_option(
       "--cubes", o.cubes,
       "edge lengths in voxels of the synthetic volumes to render at --size, comma-separated")
      ->delimiter(',')
      ->check(CLI::Range(16, 2048));
  c->add_option("--size", o.size, "picture size in pixels, WxH");
  c->add_option("--canvas-cube", o.canvas_cube,
                "edge length of the synthetic volume to render at all --canvases (0 = none)")
      ->check(CLI::Range(0, 2048));
  c->add_option("--volume", o.others, "another volume to render at all --canvases (repeatable)");
  c->add_option("--canvases", o.canvases, "picture sizes, comma-separated")->delimiter(',');
  c->add_option("--walk", o.growth_walks, "exact or tracking; comma-separated for several")
      ->delimiter(',')
      ->check(CLI::IsMember({"exact", "tracking"}));
  c->add_option("--repeats", o.growth.repeats, "repetitions per measurement")
      ->check(CLI::Range(1, 1000));
  c->add_option("--target", o.growth.target, "estimated error up to which the time is measured");
  c->add_option("--most", o.growth.most, "maximum number of samples")
      ->check(CLI::Range(4, 1 << 20));
  c->add_option("--seconds", o.growth.seconds,
                "approximate seconds per row until the target is reached");
  return c;
}

CLI::App* add_convergence(CLI::App& app, Options& o) {
  auto* c = app.add_subcommand(
      "convergence",
      "Measure time, true error and estimated error at each power of two of samples");
  c->add_option("--volume", o.volume,
                "directory of the volume store, or made:N (a synthetic head, N voxels wide)");
  auto* subject = c->add_option_group("subject")->require_option(1);
  subject->add_option("--scene", o.scene, "scene file (JSON)");
  subject->add_option("--preset", o.preset,
                      "built-in look, fitted to the volume (--list-presets of diaphane-render)");
  add_shared(*c, o);
  c->add_option("--devices", o.devices, "number of devices, each in its own process")
      ->check(CLI::Range(1, 64));
  c->add_option("--size", o.size, "picture size in pixels, WxH");
  c->add_option("--most", o.convergence.most, "samples of the last measured point, a power of two")
      ->check(CLI::Range(1, 1 << 20));
  c->add_option("--repeats", o.convergence.repeats, "repetitions, each with its own seed")
      ->check(CLI::Range(1, 1000));
  c->add_option("--walk", o.walks, "auto, exact or tracking; comma-separated for several")
      ->delimiter(',')
      ->check(CLI::IsMember({"auto", "exact", "tracking"}));
  c->add_option("--points", o.points, "low-discrepancy or independent; comma-separated for several")
      ->delimiter(',')
      ->check(CLI::IsMember({"low-discrepancy", "independent"}));
  c->add_option("--mis", o.mis, "both, light or scatter; comma-separated for several")
      ->delimiter(',')
      ->check(CLI::IsMember({"both", "light", "scatter"}));
  c->add_option("--roulette", o.roulette, "on or off; comma-separated for several")
      ->delimiter(',')
      ->check(CLI::IsMember({"on", "off"}));
  c->add_option("--target", o.head.target, "error up to which the time is measured");
  c->add_option("--slope-from", o.head.slope_from,
                "number of samples from which the slope is fitted");
  c->add_option("--warm-up", o.convergence.warm_up, "seconds to render before measuring");
  c->add_option("--reference-share", o.convergence.reference_share,
                "error of the reference, as a share of the smallest measured error");
  c->add_option("--reference-seconds", o.convergence.reference_seconds,
                "approximate time limit in seconds for the reference");
  c->add_option("--cache", o.convergence.cache, "directory in which references are cached");
  c->add_flag("--fresh", o.convergence.fresh, "do not use cached references");
  c->add_flag("--quiet", o.quiet, "show no progress on standard error");
  return c;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    Options options;
    CLI::App app("Benchmarks for the renderer.", "diaphane-renderd-bench");
    app.option_defaults()->always_capture_default();
    app.require_subcommand(1);
    add_convergence(app, options);
    const auto* stability = add_stability(app, options);
    const auto* growth = add_growth(app, options);
    const auto* phases = add_phases(app, options);
    bench::ScheduleCommand schedule(app);
    bench::MultiDeviceCommand many(app);
    CLI11_PARSE(app, argc, argv);
    if (schedule.chosen()) return schedule.run();
    if (many.chosen()) return many.run();
    if (*phases) return run_phases(options);
    if (*growth) return run_growth(options);
    return *stability ? run_stability(options) : run(options);
  } catch (const std::exception& error) {
    std::cerr << "diaphane-renderd-bench: " << error.what() << '\n';
    return 70;
  }
}
