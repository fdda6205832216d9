#include "bench/renderer/multi_device_command.h"

#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "bench/renderer/synthetic_volume.h"
#include "bench/renderer/text.h"
#include "common/try.h"
#include "renderd/scene/presets.h"

namespace diaphane::render::bench {
namespace {

constexpr int kFailed = 65, kNoDevice = 69;  // sysexits.h, as in the other subcommands

Result<Canvas> canvas_of(const std::string& text) {
  Canvas canvas;
  char end = 0;
  if (std::sscanf(text.c_str(), "%ux%u%c", &canvas.width, &canvas.height, &end) != 2) {
    return fail(ErrorCode::kInvalid, "WIDTHxHEIGHT: not '" + text + "'", "--sizes");
  }
  return canvas;
}

/// Returns a binary PPM, which most image programs can read.
std::string ppm_of(const PictureRgb8& picture) {
  std::string text = "P6\n" + std::to_string(picture.size.width) + " " +
                     std::to_string(picture.size.height) + "\n255\n";
  text.append(picture.pixels.begin(), picture.pixels.end());
  return text;
}

std::string text_of(const ErrorRow& row) {
  std::string text;
  print(text, "%6u %8u  %-15s  %9.5f  %+6.1f%%  %9.5f\n", row.passes, row.devices,
        row.low_discrepancy ? "low-discrepancy" : "independent", row.rmse, 100 * row.off,
        row.estimate);
  return text;
}

std::string text_of(const TimeRow& row) {
  std::string text;
  print(text, "%4ux%-4u  %5.3f  %-9s  %9.2f  %7.2f  %9.2f  %8.1f  %9.1f  %s\n", row.canvas.width,
        row.canvas.height, row.target, row.division.c_str(), row.milliseconds, row.spread,
        row.first, row.samples, row.megabytes, row.took.c_str());
  return text;
}

nlohmann::json json_of(const ErrorRow& row) {
  return {{"passes", row.passes},
          {"devices", row.devices},
          {"points", row.low_discrepancy ? "low-discrepancy" : "independent"},
          {"rmse", row.rmse},
          {"off", row.off},
          {"estimate", row.estimate}};
}

nlohmann::json json_of(const TimeRow& row) {
  return {{"width", row.canvas.width}, {"height", row.canvas.height},
          {"target", row.target},      {"division", row.division},
          {"took", row.took},          {"milliseconds", row.milliseconds},
          {"spread", row.spread},      {"first_milliseconds", row.first},
          {"samples", row.samples},    {"megabytes", row.megabytes}};
}

}  // namespace

struct MultiDeviceCommand::Options {
  std::string volume = "made", scene, engine = "cpu", size = "128x128", json, figure12,
              walk = "auto";
  unsigned devices = 2, threads = 0;
  std::vector<unsigned> counts{1, 2, 4};
  std::vector<std::string> sizes{"1280x720", "3840x2160"};
  std::vector<std::uint32_t> passes{2, 4, 8, 16}, snapshots{2, 8, 20};
  double reference_seconds = 60;
  bool no_errors = false, no_times = false;
  std::string cache;
  ErrorOptions errors;
  TimeOptions times;
};

MultiDeviceCommand::MultiDeviceCommand(CLI::App& app) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.times.targets = {0.05, 0.01};
  command_ = app.add_subcommand("many", "Measure several devices that render one picture together");
  CLI::App& c = *command_;
  c.add_option("--engine", o.engine, "rendering engine")->check(CLI::IsMember({"cpu", "cuda"}));
  c.add_option("--devices", o.devices, "number of GPUs, or of CPU engines that share the threads")
      ->check(CLI::Range(1, 64));
  c.add_option("--threads", o.threads, "threads of all CPU engines together (0 = one per core)");
  c.add_option("--volume", o.volume,
               "directory of the volume store, or made:N (a synthetic head, N voxels wide)");
  c.add_option("--scene", o.scene, "scene file (JSON)")->required();
  c.add_option("--counts", o.counts,
               "numbers of devices whose error is compared, comma-separated, each 1 or more")
      ->delimiter(',');
  c.add_option("--passes", o.passes, "passes per device, even numbers, comma-separated")
      ->delimiter(',');
  c.add_option("--repeats", o.errors.repeats,
               "repetitions of the error measurements, each with its own seed");
  c.add_option("--walk", o.walk, "estimator of the error measurements")
      ->check(CLI::IsMember({"auto", "exact", "tracking"}));
  c.add_option("--size", o.size, "size of the pictures whose errors are compared, WxH");
  c.add_option("--sizes", o.sizes, "sizes of the pictures whose time is measured, comma-separated")
      ->delimiter(',');
  c.add_option("--targets", o.times.targets,
               "errors up to which the time is measured, comma-separated")
      ->delimiter(',');
  c.add_option("--time-repeats", o.times.repeats, "repetitions of the time measurements");
  c.add_flag("--smoothed", o.times.smoothed, "record the guides of the denoiser, as sessions do");
  c.add_option("--warm-up", o.times.warm_up, "seconds to render before measuring");
  c.add_option("--longest", o.times.longest, "maximum seconds per picture");
  c.add_option("--reference-seconds", o.reference_seconds,
               "approximate time limit in seconds for the reference");
  c.add_option("--cache", o.cache, "directory in which references are cached");
  c.add_option("--figure12", o.figure12, "write Figure 12 of the thesis to this file as PPM");
  c.add_option("--snapshots", o.snapshots,
               "passes per row of Figure 12, even numbers, comma-separated")
      ->delimiter(',');
  c.add_option("--json", o.json, "write the results to this file as JSON");
  c.add_flag("--no-errors", o.no_errors, "measure times only");
  c.add_flag("--no-times", o.no_times, "measure errors only");
}

MultiDeviceCommand::~MultiDeviceCommand() = default;
bool MultiDeviceCommand::chosen() const { return command_->parsed(); }

int MultiDeviceCommand::run() {
  const auto done = measure();
  if (done) return 0;
  std::cerr << "diaphane-renderd-bench: "
            << (done.error().field.empty() ? "" : done.error().field + ": ") << done.error().message
            << '\n';
  return done.error().code == ErrorCode::kUnavailable ? kNoDevice : kFailed;
}

Result<void> MultiDeviceCommand::measure() {
  Options& o = *options_;
  for (const auto* list : {&o.passes, &o.snapshots}) {
    for (const std::uint32_t passes : *list) {
      if (passes == 0 || passes % 2 != 0) {
        return fail(ErrorCode::kInvalid,
                    "must contain even numbers above 0, because passes are divided in pairs",
                    "--passes");
      }
    }
  }
  const auto text = read_text(o.scene, "--scene");
  DIAPHANE_TRY(text);
  const auto scene = scene_from_json(*text);
  DIAPHANE_TRY(scene);
  auto volume = named_volume(o.volume);
  DIAPHANE_TRY(volume);
  const auto size = canvas_of(o.size);
  DIAPHANE_TRY(size);
  for (const std::string& one : o.sizes) {
    const auto canvas = canvas_of(one);
    DIAPHANE_TRY(canvas);
    o.times.canvases.push_back(*canvas);
  }
  const auto choice = o.engine == "cuda" ? EngineChoice::kCuda : EngineChoice::kCpu;
  auto devices = open_devices(choice, o.devices, o.threads, *volume);
  DIAPHANE_TRY(devices);
  const EngineInfo info = devices->engines[0]->info();
  std::cout << o.devices << " x " << info.device << ", " << o.scene << ", " << o.volume << '\n';
  nlohmann::json report{{"devices", o.devices}, {"device", info.device}, {"engine", info.engine}};
  const Subject subject{devices->engines[0].get(), devices->volumes[0], hash_of(*volume), *scene,
                        *size};
  if (!o.figure12.empty()) {
    const auto picture = side_by_side(*devices, subject, o.devices, o.snapshots);
    DIAPHANE_TRY(picture);
    if (!written(o.figure12, ppm_of(*picture))) return fail(ErrorCode::kUnavailable, "not written");
  }
  if (!o.no_errors) {
    for (const unsigned count : o.counts) {
      if (count <= o.devices) o.errors.devices.push_back(count);
    }
    o.errors.passes = o.passes;
    o.errors.walk = o.walk == "exact"      ? Walk::kExact
                    : o.walk == "tracking" ? Walk::kTracking
                                           : Walk::kAuto;
    const auto reference = reference_of(subject, {1e-4, o.reference_seconds, o.cache, false, {}});
    DIAPHANE_TRY(reference);
    std::printf("reference: %.0f samples, its own error %.5f\n", reference->samples,
                reference->error);
    std::cout << "passes  devices  points                RMSE  from 1/sqrt(k)  estimate\n";
    const auto rows = measure_errors(*devices, subject, *reference, o.errors);
    DIAPHANE_TRY(rows);
    for (const ErrorRow& row : *rows) {
      std::cout << text_of(row) << std::flush;
      report["errors"].push_back(json_of(row));
    }
  }
  if (!o.no_times) {
    std::cout << "     size  error  division          ms   spread   first ms   samples"
                 "   MB moved  the last by\n";
    o.times.each = [](const TimeRow& row) { std::cout << text_of(row) << std::flush; };
    const auto rows = measure_times(std::move(*devices), *volume, *scene, o.times);
    DIAPHANE_TRY(rows);
    for (const TimeRow& row : *rows) report["times"].push_back(json_of(row));
  }
  return written(o.json, report.dump(1) + "\n") ? Result<void>{}
                                                : fail(ErrorCode::kUnavailable, "not written");
}

}  // namespace diaphane::render::bench
