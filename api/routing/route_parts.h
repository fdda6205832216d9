#pragma once

#include <vector>

#include "api/routing/representations.h"
#include "api/routing/request_router.h"
#include "common/try.h"

/// Parts that the functions in routes.h have in common.
namespace diaphane::api {

/// Responds with the status on success, otherwise with the problem of `done`.
inline Outcome<Response> answer(const Outcome<void>& done, int status = 204) {
  DIAPHANE_TRY(done);
  return empty_response(status);
}

inline std::vector<Route> join(const std::vector<std::vector<Route>>& groups) {
  std::vector<Route> routes;
  for (const auto& group : groups) routes.insert(routes.end(), group.begin(), group.end());
  return routes;
}

}  // namespace diaphane::api
