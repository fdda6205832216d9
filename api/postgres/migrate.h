#pragma once

#include <string>
#include <vector>

#include "common/result.h"

namespace diaphane::api {

enum class Direction { kUp, kDown };

/// Applies the files `NNNN_name.up.sql` of `directory` that are not applied yet, in order, or takes
/// the newest back by their `.down.sql`; each in a transaction of its own, recorded in
/// `schema_migrations`. `steps` 0: all that there are (up), one (down). Two at once wait for each
/// other. The names of those applied, in order. kUnavailable: the server is away. kInvalid: the
/// directory, a file or its SQL is wrong.
Result<std::vector<std::string>> migrate(const std::string& url, const std::string& directory,
                                         Direction direction, int steps);

}  // namespace diaphane::api
