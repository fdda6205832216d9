#pragma once

#include <vector>

#include "api/pacs/archives.h"
#include "api/routing/request_router.h"

/// The operations of api/openapi.yaml for this feature. Arguments passed by reference must outlive
/// the routes.
namespace diaphane::api {

std::vector<Route> archive_routes(Archives& archives, Accounts& accounts);

}  // namespace diaphane::api
