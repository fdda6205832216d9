#pragma once

#include <CLI/CLI.hpp>
#include <memory>

#include "renderd/bench/many.h"

namespace diaphane::render::bench {

/// The subcommand `many` of diaphane-renderd-bench.
class ManyCommand {
 public:
  explicit ManyCommand(CLI::App& app);
  ~ManyCommand();
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
