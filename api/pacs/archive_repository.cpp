#include "api/pacs/archive_repository.h"

#include "api/shared/audit_repository.h"
#include "common/ids.h"

namespace diaphane::api {

Result<void> ArchiveRepository::note(const AuditEntry& entry, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    note_in_audit_log(transaction, entry, now);
    return {};
  });
}

Result<void> ArchiveRepository::begin_fetch(const std::string& user_id,
                                            const std::string& token_hash, Time now,
                                            Time expires_at, const AuditEntry& entry) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(
        R"sql(
        INSERT INTO api_tokens (id, user_id, token_hash, name, scopes, created_at, expires_at, for_fetch)
        VALUES ($1::uuid, $2::uuid, $3, 'fetch', 'write', to_timestamp($4::bigint / 1e6),
                to_timestamp($5::bigint / 1e6), true))sql",
        new_id(), user_id, token_hash, to_us(now), to_us(expires_at));
    note_in_audit_log(transaction, entry, now);
    return {};
  });
}

}  // namespace diaphane::api
