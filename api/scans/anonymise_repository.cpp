#include "api/scans/anonymise_repository.h"

#include "api/shared/audit_repository.h"

namespace diaphane::api {

Result<CutFacts> CutRepository::facts(const std::string& data_set_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<CutFacts> {
    const pqxx::result rows = transaction.exec_params(
        "SELECT COALESCE(head::text, '') AS head, COALESCE(cut_problem, '') AS cut_problem FROM "
        "data_sets WHERE id = $1",
        data_set_id);
    if (rows.empty()) return fail(ErrorCode::kNotFound, "Scan not found.");
    return CutFacts{rows[0]["head"].as<std::string>(), rows[0]["cut_problem"].as<std::string>()};
  });
}

Result<void> CutRepository::order(const CutOrder& order, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result queued = transaction.exec_params(
        R"sql(
        UPDATE data_sets SET state = 'queued', cut_problem = NULL, updated_at = to_timestamp($2::bigint / 1e6)
         WHERE id = $1 AND state = 'ready'
           AND NOT EXISTS (SELECT FROM ingest_jobs WHERE data_set_id = $1)
        RETURNING id)sql",
        order.data_set_id, to_us(now));
    if (queued.empty()) return fail(ErrorCode::kConflict, "The scan is not ready.");
    // Schedules the deletion of thumbnails with the old voxels, even of one that is being written.
    transaction.exec_params0("UPDATE presets SET pictured_at = NULL WHERE data_set_id = $1",
                             order.data_set_id);
    transaction.exec_params0(
        R"sql(
        INSERT INTO disposals (kind, id) SELECT 'preset', id FROM presets WHERE data_set_id = $1
        ON CONFLICT DO NOTHING)sql",
        order.data_set_id);
    transaction.exec_params0(
        R"sql(
        INSERT INTO ingest_jobs (data_set_id, cut, cut_of, asked_by)
        VALUES ($1, $2::jsonb, $3, $4::uuid))sql",
        order.data_set_id, order.region, order.volume_hash,
        order.asked_by.empty() ? nullptr : order.asked_by.c_str());
    note_in_audit_log(transaction,
                      {order.asked_by.empty() ? AuditActor::kMachine : AuditActor::kPerson,
                       order.asked_by,
                       "data-set.anonymise-ordered",
                       "data_set",
                       order.data_set_id,
                       {}},
                      now);
    transaction.exec("NOTIFY ingest_jobs");
    return {};
  });
}

}  // namespace diaphane::api
