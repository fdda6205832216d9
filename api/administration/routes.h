#pragma once

#include <vector>

#include "api/administration/administration.h"
#include "api/routing/request_router.h"

/// The operations of api/openapi.yaml for this feature. Arguments passed by reference must outlive
/// the routes.
namespace diaphane::api {

std::vector<Route> admin_routes(Administration& administration);

}  // namespace diaphane::api
