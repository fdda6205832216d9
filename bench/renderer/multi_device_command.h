#pragma once

#include <CLI/CLI.hpp>
#include <memory>

#include "bench/renderer/multi_device_bench.h"

namespace diaphane::render::bench {

/// The subcommand `many` of diaphane-renderd-bench.
class MultiDeviceCommand {
 public:
  explicit MultiDeviceCommand(CLI::App& app);
  ~MultiDeviceCommand();
  bool chosen() const;
  /// Returns the exit code.
  int run();

 private:
  struct Options;
  Result<void> measure();

  std::unique_ptr<Options> options_;
  CLI::App* command_;
};

}  // namespace diaphane::render::bench
