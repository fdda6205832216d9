#include "api/scans/scan_export_repository.h"

#include "api/shared/audit_repository.h"

namespace diaphane::api {
namespace {

/// An upper bound of the bytes of a surface, which has at most 1,000,000 triangles of 50 bytes, and
/// of what compression adds to incompressible voxels.
constexpr std::int64_t kMostOfSurface = std::int64_t{64} << 20;

std::optional<std::int64_t> number_or_null(const pqxx::field& field) {
  if (field.is_null()) return std::nullopt;
  return field.as<std::int64_t>();
}

ScanExport read_export(const pqxx::row& row) {
  return {.id = row["id"].as<std::string>(),
          .data_set_id = row["data_set_id"].as<std::string>(),
          .order = {row["format"].as<std::string>(), number_or_null(row["label"]),
                    number_or_null(row["above"]), row["phase"].as<std::int64_t>()},
          .state = row["state"].as<std::string>(),
          .bytes = row["bytes"].as<std::int64_t>(),
          .waiting = row["waiting"].as<bool>(),
          .problem_code = row["problem_code"].as<std::string>(),
          .problem_text = row["problem_text"].as<std::string>(),
          .created_at = from_us(row["created_us"].as<std::int64_t>()),
          .expires_at = from_us(row["expires_us"].as<std::int64_t>())};
}

}  // namespace

Result<ScanExportStore::Request> ScanExportRepository::request(const std::string& user_id,
                                                               const ScanExport& requested,
                                                               std::int64_t most_bytes) {
  return database_.transact([&](pqxx::work& transaction) -> Result<Request> {
    // One request at a time, so that two do not take the same room.
    transaction.exec("SELECT pg_advisory_xact_lock(hashtext('diaphane scan export'))");
    // Waits for an order to anonymise the scan, which deletes its exports.
    const pqxx::result ready = transaction.exec_params(
        "SELECT COALESCE(volume_bytes, 0) AS volume_bytes FROM data_sets WHERE id = $1::uuid AND "
        "state = 'ready' FOR SHARE",
        requested.data_set_id);
    if (ready.empty()) return Request::kNotReady;
    // Reserves room for the file until its size is known.
    const auto needed = ready[0]["volume_bytes"].as<std::int64_t>() + kMostOfSurface;
    const auto kept = transaction
                          .exec_params1(
                              R"sql(
        SELECT (COALESCE((SELECT sum(bytes) FROM exports), 0)
              + COALESCE((SELECT sum(bytes) FROM scan_exports
                           WHERE user_id <> $1::uuid OR state = 'queued'), 0))::bigint AS bytes)sql",
                              user_id)["bytes"]
                          .as<std::int64_t>();
    // Like the export of an account, a scan that is larger than this may still use an empty disk.
    if (kept > 0 && kept + needed > most_bytes) return Request::kFull;
    transaction.exec_params0(
        "DELETE FROM scan_exports WHERE user_id = $1::uuid AND state <> 'queued'", user_id);
    const ScanExportOrder& order = requested.order;
    const pqxx::result made = transaction.exec_params(
        R"sql(
        INSERT INTO scan_exports (id, user_id, data_set_id, format, label, above, phase, state, bytes, created_at,
                                  expires_at)
        VALUES ($1::uuid, $2::uuid, $3::uuid, $4, $5, $6, $7, 'queued', $8, to_timestamp($9::bigint / 1e6),
                to_timestamp($10::bigint / 1e6))
        ON CONFLICT (user_id) DO NOTHING)sql",
        requested.id, user_id, requested.data_set_id, order.format, order.label, order.above,
        order.phase, needed, to_us(requested.created_at), to_us(requested.expires_at));
    if (made.affected_rows() == 0) return Request::kBusy;
    transaction.exec("NOTIFY ingest_jobs");
    note_in_audit_log(transaction,
                      {AuditActor::kPerson,
                       user_id,
                       "data-set.export-asked",
                       "data_set",
                       requested.data_set_id,
                       {{"format", order.format}}},
                      requested.created_at);
    return Request::kMade;
  });
}

Result<std::optional<ScanExport>> ScanExportRepository::find(const std::string& user_id,
                                                             const std::string& data_set_id,
                                                             Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::optional<ScanExport>> {
    const pqxx::result found = transaction.exec_params(
        R"sql(
        SELECT id, data_set_id, format, label, above, phase, state, COALESCE(bytes, 0) AS bytes, waiting,
               COALESCE(problem_code, '') AS problem_code, COALESCE(problem_text, '') AS problem_text,
               (extract(epoch FROM created_at) * 1000000)::bigint AS created_us,
               (extract(epoch FROM expires_at) * 1000000)::bigint AS expires_us
          FROM scan_exports
         WHERE user_id = $1::uuid AND data_set_id = $2::uuid AND expires_at > to_timestamp($3::bigint / 1e6))sql",
        user_id, data_set_id, to_us(now));
    if (found.empty()) return std::nullopt;
    return read_export(found[0]);
  });
}

Result<bool> ScanExportRepository::remove(const std::string& user_id,
                                          const std::string& data_set_id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result gone = transaction.exec_params(
        "DELETE FROM scan_exports WHERE user_id = $1::uuid AND data_set_id = $2::uuid", user_id,
        data_set_id);
    return gone.affected_rows() > 0;
  });
}

Result<void> ScanExportRepository::expire(Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(
        "DELETE FROM scan_exports WHERE expires_at <= to_timestamp($1::bigint / 1e6)", to_us(now));
    return {};
  });
}

}  // namespace diaphane::api
