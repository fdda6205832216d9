#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "api/service/problem.h"

namespace diaphane::api {

struct Target {
  std::string path;                          ///< exactly as it came
  std::map<std::string, std::string> query;  ///< decoded
};

/// Takes a request target apart once, so that what is authorised is what is served. Paths are taken
/// letter for letter: no route needs an escape, `//`, `.` or `..`, and whatever has one is refused.
/// kBadRequest.
Outcome<Target> parse_target(std::string_view target);

/// The parameters of `path` when it has the form of `pattern` ("/v1/data-sets/{data_set_id}"), else
/// nothing.
std::optional<std::map<std::string, std::string>> match_path(std::string_view pattern,
                                                             std::string_view path);

}  // namespace diaphane::api
