#pragma once

#include "api/scans/data_set_store.h"
#include "api/shared/database.h"

/// Reads data sets from their rows, for all repositories that return data sets.
namespace diaphane::api {

/// A `SELECT ... WHERE` of the data sets that a viewer has a role for. Append further conditions
/// with AND. data_sets is `d`, and the viewer's role is `r.role`. $1 is viewer_or_null, $2 whether
/// the viewer is the operator of the sample, and $3 whether the viewer is an administrator.
extern const char* const kSelectDataSet;
DataSet read_data_set(const pqxx::row& row);

/// Returns the public name, or an empty string for a name that was chosen before names were
/// validated and would be refused now.
std::string shown_name(std::string name);

/// Returns the viewer as an SQL parameter. NULL means a viewer without an account, or the operator
/// of the sample.
inline const char* viewer_or_null(const Viewer& viewer) {
  return viewer.user_id.empty() ? nullptr : viewer.user_id.c_str();
}

/// Assigns the pending invitations for a user's confirmed address to this user.
void accept_invitations(pqxx::work& transaction, const std::string& user_id);

}  // namespace diaphane::api
