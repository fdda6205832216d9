#pragma once

#include <vector>

#include "api/handlers/request_router.h"
#include "api/service/account_changes.h"
#include "api/service/account_deletion.h"
#include "api/service/accounts.h"
#include "api/service/administration.h"
#include "api/service/anonymise.h"
#include "api/service/data_sets.h"
#include "api/service/exports.h"
#include "api/service/live_links.h"
#include "api/service/preset_pictures.h"
#include "api/service/presets.h"
#include "api/service/recordings.h"
#include "api/service/render_time.h"
#include "api/service/reports.h"
#include "api/service/second_factor.h"
#include "api/service/sessions.h"
#include "api/service/sharing.h"
#include "api/service/thumbnails.h"
#include "api/service/uploads.h"

/// Adds the operations of api/openapi.yaml, one function per group. Arguments passed by reference
/// must outlive the routes.
namespace diaphane::api {

std::vector<Route> account_routes(Accounts& accounts, RenderTime& render_time,
                                  const RequestRouter& router);
std::vector<Route> account_change_routes(AccountChanges& changes, const RequestRouter& router);
std::vector<Route> second_factor_routes(SecondFactors& factors);
std::vector<Route> admin_routes(Administration& administration);
std::vector<Route> privacy_routes(Exports& exports, AccountDeletion& deletion,
                                  const RequestRouter& router);
std::vector<Route> data_set_routes(DataSets& data_sets, Thumbnails& thumbnails);
/// Creating an upload with tus announces a data set, like POST /v1/data-sets.
std::vector<Route> upload_routes(Uploads& uploads, DataSets& data_sets);
std::vector<Route> session_routes(Sessions& sessions);
std::vector<Route> live_routes(LiveLinks& links, const RequestRouter& router);
std::vector<Route> sharing_routes(Sharing& sharing, const RequestRouter& router);
std::vector<Route> anonymise_routes(Anonymise& anonymise);
std::vector<Route> visit_routes(Visits& visits);
std::vector<Route> preset_routes(Presets& presets, PresetPictures& pictures);
std::vector<Route> report_routes(Reports& reports);
std::vector<Route> recording_routes(Recordings& recordings);

}  // namespace diaphane::api
