#pragma once

#include <functional>
#include <string_view>

#include "common/result.h"

namespace diaphane::ingest {

/// Receives the bytes of a file in order. An error ends the writing and is returned to its caller.
using Sink = std::function<Result<void>(std::string_view)>;

}  // namespace diaphane::ingest
