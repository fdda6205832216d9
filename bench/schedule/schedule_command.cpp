#include "bench/schedule/schedule_command.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "bench/renderer/synthetic_volume.h"
#include "bench/renderer/text.h"
#include "bench/schedule/figure9.h"
#include "bench/schedule/real_run.h"
#include "bench/schedule/schedule_results.h"
#include "common/try.h"
#include "renderd/scene/presets.h"

namespace diaphane::render::bench {
namespace {

constexpr int kFailed = 65, kNoDevice = 69;  // sysexits.h, as in the other subcommands

int complain(const Error& error) {
  std::cerr << "diaphane-renderd-bench: " << (error.field.empty() ? "" : error.field + ": ")
            << error.message << '\n';
  return error.code == ErrorCode::kUnavailable ? kNoDevice : kFailed;
}

std::vector<std::string> policy_names() {
  std::vector<std::string> names;
  for (const PolicyKind kind : kPolicyKinds) names.emplace_back(policy_name(kind));
  return names;
}

}  // namespace

struct ScheduleCommand::Options {
  bool real = false;
  std::string engine = "cpu", volume = "made:64", scenes;
  unsigned threads = 0;
  double scale = 1;
  std::string costs_out, figure9;
  std::vector<std::string> policies = policy_names();
  std::vector<std::size_t> sessions{2, 4, 16, 64, 256};
  std::vector<std::string> traces{std::begin(kTraceKinds), std::end(kTraceKinds)};
  double seconds = 30;
  unsigned seeds = 5;
  std::uint64_t seed = 1;
  std::string costs = "h200";
  std::size_t fleet_sessions = 0, fleet_devices = 0;
  double target = 0.01;
  std::string json, csv, write_traces;
  bool quiet = false;
};

ScheduleCommand::ScheduleCommand(CLI::App& app) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  command_ = app.add_subcommand("schedule", "Compare scheduling policies over interaction traces");
  CLI::App& c = *command_;
  c.add_option("--policy", o.policies, "scheduling policies, comma-separated")
      ->delimiter(',')
      ->check(CLI::IsMember(policy_names()));
  c.add_option("--sessions", o.sessions, "numbers of sessions, comma-separated")->delimiter(',');
  c.add_option("--trace", o.traces,
               "interactive, mixed, idle, or a file written by --write-traces; comma-separated")
      ->delimiter(',');
  c.add_option("--seconds", o.seconds, "length of each trace in seconds")
      ->check(CLI::Range(0.1, 3600.0));
  c.add_option("--seeds", o.seeds, "number of traces per kind and size")
      ->check(CLI::Range(1, 1000));
  c.add_option("--seed", o.seed, "seed of the first trace");
  c.add_option("--costs", o.costs,
               "costs of the simulated device: h200, cpu2, or a file written by --costs-out");
  c.add_option("--fleet-sessions", o.fleet_sessions,
               "also simulate a fleet with this many sessions");
  c.add_option("--fleet-devices", o.fleet_devices, "number of devices of the simulated fleet");
  c.add_option("--target", o.target, "error at which a picture counts as converged");
  c.add_option("--json", o.json, "write the results to this file as JSON");
  c.add_option("--csv", o.csv, "write the results to this file as CSV");
  c.add_option("--write-traces", o.write_traces, "write the traces to this directory as JSON");
  c.add_option("--figure9", o.figure9,
               "print Figure 9 of the thesis and write it to this file as JSON");
  c.add_flag("--quiet", o.quiet, "show no progress on standard error");
  c.add_flag("--real", o.real, "use the real renderer in real time instead of a simulation");
  c.add_option("--engine", o.engine, "rendering engine for --real")
      ->check(CLI::IsMember({"cpu", "cuda"}));
  c.add_option("--threads", o.threads, "threads of the CPU engine (0 = one per core)");
  c.add_option("--volume", o.volume,
               "directory of the volume store, or made:N (a synthetic head, N voxels wide)");
  c.add_option("--scenes", o.scenes, "directory of the scene files (tests/scenes), for --real");
  c.add_option("--scale", o.scale, "scale of the traces' viewports, to suit slow devices")
      ->check(CLI::Range(0.01, 4.0));
  c.add_option("--costs-out", o.costs_out,
               "write the costs of the real device to this file, for --costs");
}

ScheduleCommand::~ScheduleCommand() = default;
bool ScheduleCommand::chosen() const { return command_->parsed(); }

namespace {

bool shows(bool quiet) { return !quiet && ::isatty(STDERR_FILENO) == 1; }

}  // namespace

/// The resources of a real run.
struct ScheduleCommand::Device {
  std::unique_ptr<Engine> engine;
  std::shared_ptr<const DeviceVolume> volume;
  std::unique_ptr<Stage> stage;
  DeviceModel model;
};

Result<void> ScheduleCommand::open(Device& device) const {
  const Options& o = *options_;
  auto engine =
      make_engine(o.engine == "cuda" ? EngineChoice::kCuda : EngineChoice::kCpu, o.threads);
  DIAPHANE_TRY(engine);
  device.engine = std::move(*engine);
  auto volume = named_volume(o.volume);
  DIAPHANE_TRY(volume);
  auto loaded = device.engine->load(*volume);
  DIAPHANE_TRY(loaded);
  device.volume = std::move(*loaded);
  device.stage =
      std::make_unique<Stage>(Stage{*device.engine, device.volume, {}, {.target_error = o.target}});
  for (const char* name : kTraceScenes) {
    auto text = read_text(o.scenes + "/" + name + ".json", "--scenes");
    DIAPHANE_TRY(text);
    auto scene = scene_from_json(*text);
    DIAPHANE_TRY(scene);
    device.stage->scenes[name] = std::move(*scene);
  }
  auto model = measure_costs(*device.stage, o.scale);
  DIAPHANE_TRY(model);
  device.model = std::move(*model);
  return {};
}

Result<ScheduleReport> ScheduleCommand::measure() const {
  const Options& o = *options_;
  ScheduleReport report;
  Device device;
  if (o.real) {
    DIAPHANE_TRY(open(device));
    report.how = "real";
    report.model = device.model;
  } else {
    auto model = device_model(o.costs);
    DIAPHANE_TRY(model);
    report.how = "simulated";
    report.model = std::move(*model);
  }
  report.device = report.model.name;
  report.seconds = o.seconds;
  const LedgerRules rules{.target_error = o.target};
  for (const std::string& kind : o.traces) {
    for (const std::size_t sessions : o.sessions) {
      for (const std::string& name : o.policies) {
        ScheduleRow row{kind, sessions, *policy_kind(name), {}};
        for (unsigned i = 0; i < o.seeds; ++i) {
          auto trace = trace_of(kind, sessions, i);
          DIAPHANE_TRY(trace);
          row.sessions = trace->sessions.size();
          auto policy = make_policy(row.policy, {}, o.seed + i);
          if (o.real) {
            if (shows(o.quiet)) std::cerr << kind << ' ' << sessions << ' ' << name << '\n';
            auto run = run_real(*trace, *device.stage, report.model, std::move(policy));
            DIAPHANE_TRY(run);
            row.runs.push_back(run->scores);
          } else {
            row.runs.push_back(simulate(*trace, report.model, std::move(policy), rules).scores);
          }
        }
        report.rows.push_back(std::move(row));
      }
    }
  }
  if (o.fleet_sessions > 0 && !o.real) measure_fleet(report);
  if (o.real) {
    DIAPHANE_TRY(measure_sharing(*device.stage, report));
  }
  for (const std::string& name : o.policies) {
    report.decisions.push_back(measure_decision(*policy_kind(name), 256, 5));
  }
  return report;
}

Result<Trace> ScheduleCommand::trace_of(const std::string& kind, std::size_t sessions,
                                        unsigned number) const {
  const Options& o = *options_;
  if (std::find(std::begin(kTraceKinds), std::end(kTraceKinds), kind) == std::end(kTraceKinds)) {
    auto text = read_text(kind, "--trace");
    DIAPHANE_TRY(text);
    return trace_of_json(*text);
  }
  Trace trace = make_trace(kind, sessions, o.seconds, o.seed + number);
  for (TraceSession& session : trace.sessions) {
    if (o.scale != 1) session.viewport = scaled(session.viewport, o.scale);
  }
  if (!o.write_traces.empty()) {
    const std::string name =
        kind + "-" + std::to_string(sessions) + "-" + std::to_string(o.seed + number) + ".json";
    if (!written(o.write_traces + "/" + name, trace_json(trace))) {
      return fail(ErrorCode::kInvalid, "no such folder: " + o.write_traces, "--write-traces");
    }
  }
  return trace;
}

Result<void> ScheduleCommand::measure_sharing(const Stage& stage, ScheduleReport& report) const {
  const double seconds = std::min(2.0, options_->seconds / 4);
  for (const std::size_t sessions : {1, 16}) {
    SharingRow row{sessions, {}};
    for (unsigned i = 0; i < options_->seeds; ++i) {
      const auto alone = rate_alone(stage, options_->scale, seconds);
      DIAPHANE_TRY(alone);
      const auto shared = rate_shared(stage, options_->scale, sessions, seconds);
      DIAPHANE_TRY(shared);
      row.lost.push_back(1 - *shared / *alone);
    }
    report.sharing.push_back(std::move(row));
  }
  return {};
}

void ScheduleCommand::measure_fleet(ScheduleReport& report) const {
  const Options& o = *options_;
  const std::size_t devices = std::max<std::size_t>(o.fleet_devices, 1);
  constexpr unsigned kMostSeeds = 3;  // because each takes a minute
  for (const std::string& kind : o.traces) {
    for (const Placement placement : kPlacements) {
      FleetRow row{o.fleet_sessions, devices, kind, placement, {}};
      for (unsigned i = 0; i < std::min(o.seeds, kMostSeeds); ++i) {
        const Trace trace = make_trace(kind, o.fleet_sessions, o.seconds, o.seed + i);
        row.runs.push_back(simulate_fleet(trace, devices, report.model, PolicyKind::kMarginalGain,
                                          placement, {.target_error = o.target}));
      }
      report.fleet.push_back(std::move(row));
    }
  }
}

int ScheduleCommand::run() {
  const Options& o = *options_;
  if (!o.figure9.empty()) {
    const auto situations = figure9(o.seed);
    std::cout << figure9_text(situations) << std::flush;
    return written(o.figure9, figure9_json(situations)) ? 0 : kFailed;
  }
  const auto report = measure();
  if (!report) return complain(report.error());
  std::cout << schedule_text(*report) << std::flush;
  return written(o.json, schedule_json(*report)) && written(o.csv, schedule_csv(*report)) &&
                 written(o.costs_out, device_model_json(report->model))
             ? 0
             : kFailed;
}

}  // namespace diaphane::render::bench
