#pragma once

#include "renderd/cli/options.h"

namespace diaphane::render::cli {

/// Reads, renders, writes. The exit code; what went wrong is on standard error.
int run(const Options& options);

}  // namespace diaphane::render::cli
