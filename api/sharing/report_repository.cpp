#include "api/sharing/report_repository.h"

#include "api/shared/audit_repository.h"

namespace diaphane::api {
namespace {

/// Closes the reports whose `column` is `id` after a take-down, and adds the audit entry.
Result<void> close_reports(pqxx::work& transaction, const std::string& column,
                           const std::string& id, const AuditEntry& entry, Time now) {
  transaction.exec_params0("UPDATE reports SET closed_at = to_timestamp($2::bigint / 1e6) WHERE " +
                               column + " = $1 AND closed_at IS NULL",
                           id, to_us(now));
  note_in_audit_log(transaction, entry, now);
  return {};
}

}  // namespace

Result<void> ReportRepository::report(const Report& report, const std::string& reporter_id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const std::string about =
        report.preset_id.empty()
            ? "(data_set_id, reporter_id) WHERE closed_at IS NULL AND preset_id IS NULL"
            : "(preset_id, reporter_id) WHERE closed_at IS NULL AND preset_id IS NOT NULL";
    transaction.exec_params0(
        R"sql(
        INSERT INTO reports (id, data_set_id, preset_id, reporter_id, reason, words, created_at)
        SELECT $1, d.id, $7::uuid, $3, $4, $5, to_timestamp($6::bigint / 1e6) FROM data_sets d
         WHERE d.id = $2 AND ($7::uuid IS NULL OR EXISTS (SELECT 1 FROM presets WHERE id = $7::uuid))
        ON CONFLICT )sql" +
            about + " DO UPDATE SET reason = excluded.reason, words = excluded.words",
        report.id, report.data_set_id, reporter_id, report.reason, report.words,
        to_us(report.created_at), report.preset_id.empty() ? nullptr : report.preset_id.c_str());
    return {};
  });
}

Result<std::vector<Report>> ReportRepository::open(int limit, const AuditEntry& entry, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::vector<Report>> {
    // Administrators must not see a data set that has become private, not even its title.
    const pqxx::result rows = transaction.exec_params(
        R"sql(
        SELECT r.id AS report_id, d.id AS data_set_id, CASE WHEN s.shown THEN d.title ELSE '' END AS title,
               COALESCE(p.id::text, '') AS preset_id,
               CASE WHEN s.shown THEN COALESCE(p.name, '') ELSE '' END AS preset_name, r.reason, r.words,
               (CASE WHEN p.id IS NULL THEN d.taken_down_at ELSE p.taken_down_at END) IS NOT NULL AS taken_down,
               (extract(epoch FROM r.created_at) * 1000000)::bigint AS created_us
          FROM reports r JOIN data_sets d ON d.id = r.data_set_id LEFT JOIN presets p ON p.id = r.preset_id
          CROSS JOIN LATERAL (SELECT d.visibility = 'public' OR d.taken_down_at IS NOT NULL AS shown) s
         WHERE r.closed_at IS NULL ORDER BY r.created_at, r.id LIMIT $1)sql",
        limit);
    std::vector<Report> found;
    for (const pqxx::row& row : rows) {
      found.push_back({row["report_id"].as<std::string>(), row["data_set_id"].as<std::string>(),
                       row["title"].as<std::string>(), row["preset_id"].as<std::string>(),
                       row["preset_name"].as<std::string>(), row["reason"].as<std::string>(),
                       row["words"].as<std::string>(), row["taken_down"].as<bool>(),
                       from_us(row["created_us"].as<std::int64_t>())});
    }
    note_in_audit_log(transaction, entry, now);
    return found;
  });
}

Result<int> ReportRepository::count_open() {
  return database_.transact([&](pqxx::work& transaction) -> Result<int> {
    return transaction.exec1("SELECT count(*) FROM reports WHERE closed_at IS NULL")[0].as<int>();
  });
}

Result<std::vector<TakeDown>> ReportRepository::taken_down(int limit, const AuditEntry& entry,
                                                           Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::vector<TakeDown>> {
    const pqxx::result rows = transaction.exec_params(
        R"sql(
        SELECT data_set_id, title, preset_id, preset_name, reason,
               (extract(epoch FROM at) * 1000000)::bigint AS taken_down_us
          FROM (SELECT id AS data_set_id, title, '' AS preset_id, '' AS preset_name,
                       taken_down_reason AS reason, taken_down_at AS at
                  FROM data_sets WHERE taken_down_at IS NOT NULL
                UNION ALL
                SELECT d.id, d.title, p.id::text, p.name, p.taken_down_reason, p.taken_down_at
                  FROM presets p JOIN data_sets d ON d.id = p.data_set_id
                 WHERE p.taken_down_at IS NOT NULL
                   AND (d.visibility = 'public' OR d.taken_down_at IS NOT NULL)) hidden
         ORDER BY at DESC, data_set_id, preset_id LIMIT $1)sql",
        limit);
    std::vector<TakeDown> found;
    for (const pqxx::row& row : rows) {
      found.push_back({row["data_set_id"].as<std::string>(), row["title"].as<std::string>(),
                       row["preset_id"].as<std::string>(), row["preset_name"].as<std::string>(),
                       row["reason"].as<std::string>(),
                       from_us(row["taken_down_us"].as<std::int64_t>())});
    }
    note_in_audit_log(transaction, entry, now);
    return found;
  });
}

Result<void> ReportRepository::close(const std::string& report_id, const AuditEntry& entry,
                                     Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result closed = transaction.exec_params(
        R"sql(UPDATE reports SET closed_at = to_timestamp($2::bigint / 1e6)
               WHERE id = $1 AND closed_at IS NULL RETURNING 1)sql",
        report_id, to_us(now));
    if (closed.empty()) return fail(ErrorCode::kNotFound, "Report not found.");
    note_in_audit_log(transaction, entry, now);
    return {};
  });
}

Result<void> ReportRepository::take_down(const std::string& data_set_id, const std::string& reason,
                                         const AuditEntry& entry, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result taken = transaction.exec_params(
        R"sql(
        UPDATE data_sets SET visibility = 'private', published_at = NULL, taken_down_reason = $2,
                             taken_down_at = to_timestamp($3::bigint / 1e6),
                             updated_at = to_timestamp($3::bigint / 1e6)
         WHERE id = $1 RETURNING 1)sql",
        data_set_id, reason, to_us(now));
    if (taken.empty()) return fail(ErrorCode::kNotFound, "Scan not found.");
    transaction.exec_params0("DELETE FROM data_set_people WHERE data_set_id = $1", data_set_id);
    transaction.exec_params0("DELETE FROM data_set_links WHERE data_set_id = $1", data_set_id);
    return close_reports(transaction, "data_set_id", data_set_id, entry, now);
  });
}

Result<void> ReportRepository::restore(const std::string& data_set_id, const AuditEntry& entry,
                                       Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result lifted = transaction.exec_params(
        R"sql(
        UPDATE data_sets SET taken_down_at = NULL, taken_down_reason = NULL,
                             visibility = CASE WHEN is_sample THEN 'public' ELSE 'private' END,
                             published_at = CASE WHEN is_sample THEN created_at END,
                             updated_at = to_timestamp($2::bigint / 1e6)
         WHERE id = $1 AND taken_down_at IS NOT NULL RETURNING 1)sql",
        data_set_id, to_us(now));
    if (lifted.empty()) return {};
    note_in_audit_log(transaction, entry, now);
    return {};
  });
}

Result<void> ReportRepository::take_down_preset(const std::string& preset_id,
                                                const std::string& reason, const AuditEntry& entry,
                                                Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result taken = transaction.exec_params(
        R"sql(
        UPDATE presets SET taken_down_reason = $2, taken_down_at = to_timestamp($3::bigint / 1e6)
         WHERE id = $1 RETURNING 1)sql",
        preset_id, reason, to_us(now));
    if (taken.empty()) return fail(ErrorCode::kNotFound, "Preset not found.");
    transaction.exec_params0(
        "UPDATE data_sets SET default_preset_id = NULL WHERE default_preset_id = $1", preset_id);
    return close_reports(transaction, "preset_id", preset_id, entry, now);
  });
}

Result<void> ReportRepository::restore_preset(const std::string& preset_id, const AuditEntry& entry,
                                              Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const pqxx::result lifted = transaction.exec_params(
        R"sql(
        UPDATE presets SET taken_down_at = NULL, taken_down_reason = NULL
         WHERE id = $1 AND taken_down_at IS NOT NULL RETURNING 1)sql",
        preset_id);
    if (lifted.empty()) return {};
    note_in_audit_log(transaction, entry, now);
    return {};
  });
}

}  // namespace diaphane::api
