#pragma once

#include <vector>

#include "api/handlers/front.h"
#include "api/service/accounts.h"
#include "api/service/data_sets.h"
#include "api/service/live_links.h"
#include "api/service/recordings.h"
#include "api/service/sessions.h"
#include "api/service/thumbnails.h"
#include "api/service/uploads.h"

/// The operations of api/openapi.yaml, a family a function. What is given by reference must outlive
/// the routes.
namespace diaphane::api {

std::vector<Route> account_routes(Accounts& accounts, const Front& front);
std::vector<Route> data_set_routes(DataSets& data_sets, Thumbnails& thumbnails);
/// `max_upload_bytes` is announced as Tus-Max-Size.
std::vector<Route> upload_routes(Uploads& uploads, std::int64_t max_upload_bytes);
std::vector<Route> session_routes(Sessions& sessions);
std::vector<Route> live_routes(LiveLinks& links);
std::vector<Route> recording_routes(Recordings& recordings);

}  // namespace diaphane::api
