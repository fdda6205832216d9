#pragma once

#include "api/shared/audit.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// Appends to the audit log in the transaction of the change that the entry records.
void note_in_audit_log(pqxx::work& transaction, const AuditEntry& entry, Time now);

}  // namespace diaphane::api
