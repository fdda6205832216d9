#pragma once

#include "api/shared/audit.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// Appends to the audit log in the transaction of the change that the entry records.
void note_in_audit_log(pqxx::work& transaction, const AuditEntry& entry, Time now);

/// Appends an entry like note_in_audit_log, unless there is an equal entry after `not_since`.
void note_once_in_audit_log(pqxx::work& transaction, const AuditEntry& entry, Time not_since,
                            Time now);

}  // namespace diaphane::api
