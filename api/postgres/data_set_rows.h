#pragma once

#include "api/postgres/database.h"
#include "api/service/data_set_store.h"

/// How a data set is read from its row: shared by the repositories that list data sets.
namespace diaphane::api {

/// `SELECT ... WHERE` those to which a viewer is something, further conditions to be appended by
/// AND: data_sets is `d`, the viewer's role `r.role`. $1 viewer_or_null, $2 whether he is the
/// sample's operator, $3 whether an administrator.
extern const char* const kSelectDataSet;
DataSet read_data_set(const pqxx::row& row);

/// A public name; empty where it was chosen before names were checked and would be refused now.
std::string shown_name(std::string name);

/// As SQL has it: NULL is nobody, or the sample's operator.
inline const char* viewer_or_null(const Viewer& viewer) {
  return viewer.user_id.empty() ? nullptr : viewer.user_id.c_str();
}

/// What waited for the address that this person has confirmed is his from now on.
void accept_invitations(pqxx::work& transaction, const std::string& user_id);

}  // namespace diaphane::api
