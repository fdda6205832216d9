#include "api/shared/audit_repository.h"

namespace diaphane::api {
namespace {

const char* or_null(const std::string& id) { return id.empty() ? nullptr : id.c_str(); }

}  // namespace

void note_in_audit_log(pqxx::work& transaction, const AuditEntry& entry, Time now) {
  transaction.exec_params0(
      R"sql(
      INSERT INTO audit_log (happened_at, actor, actor_id, action, subject, subject_id, details)
      VALUES (to_timestamp($1::bigint / 1e6), $2, $3::uuid, $4, $5, $6::uuid, $7::jsonb))sql",
      to_us(now), std::string(to_string(entry.actor)), or_null(entry.actor_id), entry.action,
      entry.subject, or_null(entry.subject_id), details_as_json(entry.details));
}

void note_once_in_audit_log(pqxx::work& transaction, const AuditEntry& entry, Time not_since,
                            Time now) {
  const pqxx::result before = transaction.exec_params(
      R"sql(
      SELECT FROM audit_log
       WHERE subject_id = $1::uuid AND action = $2 AND actor_id IS NOT DISTINCT FROM $3::uuid
         AND details = $4::jsonb AND happened_at > to_timestamp($5::bigint / 1e6) LIMIT 1)sql",
      entry.subject_id, entry.action, or_null(entry.actor_id), details_as_json(entry.details),
      to_us(not_since));
  if (before.empty()) note_in_audit_log(transaction, entry, now);
}

}  // namespace diaphane::api
