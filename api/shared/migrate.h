#pragma once

#include <string>
#include <vector>

#include "common/result.h"

namespace diaphane::api {

enum class Direction { kUp, kDown };

/// Applies the pending files `NNNN_name.up.sql` of `directory` in order, or reverts the newest with
/// their `.down.sql`. Each runs in its own transaction and is recorded in `schema_migrations`.
/// `steps` 0 means all (up) or one (down). Concurrent calls wait for each other. Returns the names
/// of the migrations run, kUnavailable if the server is unavailable, or kInvalid if the directory,
/// a file or its SQL is invalid.
Result<std::vector<std::string>> migrate(const std::string& url, const std::string& directory,
                                         Direction direction, int steps);

}  // namespace diaphane::api
