#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "bench/schedule/schedule_results.h"

namespace diaphane::render::bench {

struct Stage;

/// The subcommand `schedule` of diaphane-renderd-bench.
class ScheduleCommand {
 public:
  explicit ScheduleCommand(CLI::App& app);
  ~ScheduleCommand();
  bool chosen() const;
  /// Returns the exit code.
  int run();

 private:
  struct Options;
  struct Device;
  Result<void> open(Device& device) const;
  Result<ScheduleReport> measure() const;
  void measure_fleet(ScheduleReport& report) const;
  Result<void> measure_sharing(const Stage& stage, ScheduleReport& report) const;
  Result<Trace> trace_of(const std::string& kind, std::size_t sessions, unsigned number) const;

  std::unique_ptr<Options> options_;
  CLI::App* command_;
};

}  // namespace diaphane::render::bench
