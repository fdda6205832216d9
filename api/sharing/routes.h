#pragma once

#include <vector>

#include "api/routing/request_router.h"
#include "api/scans/thumbnails.h"
#include "api/sharing/live_links.h"
#include "api/sharing/reports.h"
#include "api/sharing/sharing.h"

/// The operations of api/openapi.yaml for this feature. Arguments passed by reference must outlive
/// the routes.
namespace diaphane::api {

std::vector<Route> sharing_routes(Sharing& sharing, const RequestRouter& router);
std::vector<Route> visit_routes(Visits& visits, Thumbnails& thumbnails);
std::vector<Route> live_routes(LiveLinks& links, const RequestRouter& router);
std::vector<Route> report_routes(Reports& reports);

}  // namespace diaphane::api
