#include "renderd/bench/schedule/schedule_command.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <sstream>

#include "renderd/bench/schedule/schedule_results.h"

namespace diaphane::render::bench {
namespace {

constexpr int kFailed = 65, kNoDevice = 69;  // sysexits.h, as the other subcommands

int complain(const Error& error) {
  std::cerr << "diaphane-renderd-bench: " << (error.field.empty() ? "" : error.field + ": ")
            << error.message << '\n';
  return error.code == ErrorCode::kUnavailable ? kNoDevice : kFailed;
}

bool written(const std::string& path, const std::string& text) {
  if (path.empty()) return true;
  std::ofstream file(path);
  file << text << std::flush;
  if (!file) std::cerr << "diaphane-renderd-bench: cannot write " << path << '\n';
  return static_cast<bool>(file);
}

std::vector<std::string> policy_names() {
  std::vector<std::string> names;
  for (const PolicyKind kind : kPolicyKinds) names.emplace_back(policy_name(kind));
  return names;
}

}  // namespace

struct ScheduleCommand::Options {
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
  command_ = app.add_subcommand("schedule", "policies of the scheduler over traces of interaction");
  CLI::App& c = *command_;
  c.add_option("--policy", o.policies, "with commas")
      ->delimiter(',')
      ->check(CLI::IsMember(policy_names()));
  c.add_option("--sessions", o.sessions, "with commas")->delimiter(',');
  c.add_option("--trace", o.traces, "interactive, mixed, idle, or a file that --write-traces wrote")
      ->delimiter(',');
  c.add_option("--seconds", o.seconds, "of a trace")->check(CLI::Range(0.1, 3600.0));
  c.add_option("--seeds", o.seeds, "traces of each kind and size")->check(CLI::Range(1, 1000));
  c.add_option("--seed", o.seed, "of the first");
  c.add_option("--costs", o.costs, "of the simulated device: h200, cpu2, or a file of --real");
  c.add_option("--fleet-sessions", o.fleet_sessions, "simulate a fleet too: so many sessions");
  c.add_option("--fleet-devices", o.fleet_devices, "on so many devices");
  c.add_option("--target", o.target, "error at which a picture counts as converged");
  c.add_option("--json", o.json, "results");
  c.add_option("--csv", o.csv, "results");
  c.add_option("--write-traces", o.write_traces, "folder: the traces, as JSON");
  c.add_flag("--quiet", o.quiet, "no progress on standard error");
}

ScheduleCommand::~ScheduleCommand() = default;
bool ScheduleCommand::chosen() const { return command_->parsed(); }

int ScheduleCommand::run() {
  const Options& o = *options_;
  auto model = device_model(o.costs);
  if (!model) return complain(model.error());
  const LedgerRules rules{.target_error = o.target};
  ScheduleReport report{.how = "simulated",
                        .device = model->name,
                        .seconds = o.seconds,
                        .rows = {},
                        .fleet = {},
                        .decisions = {},
                        .model = *model};
  for (const std::string& kind : o.traces) {
    for (const std::size_t sessions : o.sessions) {
      for (const std::string& name : o.policies) {
        ScheduleRow row{kind, sessions, *policy_kind(name), {}};
        for (unsigned i = 0; i < o.seeds; ++i) {
          const Trace trace = make_trace(kind, sessions, o.seconds, o.seed + i);
          row.runs.push_back(
              simulate(trace, *model, make_policy(row.policy, {}, o.seed + i), rules).scores);
        }
        report.rows.push_back(std::move(row));
      }
    }
  }
  for (const std::string& name : o.policies) {
    report.decisions.push_back(measure_decision(*policy_kind(name), 256, 5));
  }
  std::cout << schedule_text(report) << std::flush;
  return written(o.json, schedule_json(report)) && written(o.csv, schedule_csv(report)) ? 0
                                                                                        : kFailed;
}

}  // namespace diaphane::render::bench
