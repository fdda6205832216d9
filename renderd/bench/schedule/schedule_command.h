#pragma once

#include <memory>
#include <string>

namespace CLI {
class App;
}

namespace diaphane::render::bench {

/// The subcommand `schedule` of diaphane-renderd-bench.
class ScheduleCommand {
 public:
  explicit ScheduleCommand(CLI::App& app);
  ~ScheduleCommand();
  bool chosen() const;
  /// Exit code.
  int run();

 private:
  struct Options;
  std::unique_ptr<Options> options_;
  CLI::App* command_;
};

}  // namespace diaphane::render::bench
