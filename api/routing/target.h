#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "api/shared/problem.h"

namespace diaphane::api {

struct Target {
  std::string path;                          ///< unmodified path
  std::map<std::string, std::string> query;  ///< decoded
};

/// Parses a request target. It is parsed only once, so that the authorised target is the served
/// one. Paths are compared literally. No route needs an escape, `//`, `.` or `..`, so a path that
/// contains one is refused with kBadRequest.
Outcome<Target> parse_target(std::string_view target);

/// Returns the parameters of `path` if it matches `pattern` ("/v1/data-sets/{data_set_id}"),
/// otherwise nothing.
std::optional<std::map<std::string, std::string>> match_path(std::string_view pattern,
                                                             std::string_view path);

}  // namespace diaphane::api
