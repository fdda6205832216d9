#pragma once

#include <vector>

#include "api/privacy/account_deletion.h"
#include "api/privacy/exports.h"
#include "api/routing/request_router.h"

/// The operations of api/openapi.yaml for this feature. Arguments passed by reference must outlive
/// the routes.
namespace diaphane::api {

std::vector<Route> privacy_routes(Exports& exports, AccountDeletion& deletion,
                                  const RequestRouter& router);

}  // namespace diaphane::api
