#pragma once

#include "renderd/cli/options.h"

namespace diaphane::render::cli {

/// Reads the input, renders and writes the picture. Prints errors to standard error and returns the
/// exit code.
int run(const Options& options);

}  // namespace diaphane::render::cli
