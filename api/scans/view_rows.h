#pragma once

#include <string>
#include <vector>

#include "api/scans/view_log.h"
#include "api/shared/database.h"

/// The rows of the view log, for all repositories that record views.
namespace diaphane::api {

/// Adds a view of each of the data sets, or counts it in an entry of the last hour (kSameView).
/// Deletes the oldest entries beyond kMostViews.
void note_views(pqxx::work& transaction, const std::vector<std::string>& data_set_ids,
                const View& view, Time now);

std::vector<ViewEntry> read_views(pqxx::work& transaction, const std::string& data_set_id,
                                  const ViewQuery& query);

/// Anonymises the entries of an account that is being deleted.
void forget_viewer(pqxx::work& transaction, const std::string& user_id);

}  // namespace diaphane::api
