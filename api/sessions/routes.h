#pragma once

#include <vector>

#include "api/routing/request_router.h"
#include "api/sessions/sessions.h"

/// The operations of api/openapi.yaml for this feature. Arguments passed by reference must outlive
/// the routes.
namespace diaphane::api {

std::vector<Route> session_routes(Sessions& sessions);

}  // namespace diaphane::api
