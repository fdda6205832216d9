#include "api/privacy/privacy_repository.h"

#include "api/accounts/account_repository.h"
#include "api/scans/view_rows.h"
#include "api/shared/audit_repository.h"

namespace diaphane::api {
namespace {

constexpr int kExportAttempts = 3;

/// A column that links rows to an account or to a data set.
struct Belonging {
  std::string table, column;
};

std::vector<Belonging> belongings(pqxx::work& transaction, const char* to, bool without_users) {
  std::vector<Belonging> found;
  for (const pqxx::row& row : transaction.exec_params(
           R"sql(
           SELECT c.conrelid::regclass::text AS table_name, a.attname AS column_name
             FROM pg_constraint c JOIN pg_attribute a ON a.attrelid = c.conrelid AND a.attnum = c.conkey[1]
            WHERE c.contype = 'f' AND c.confrelid = $1::regclass
              AND NOT ($2 AND EXISTS (SELECT FROM pg_constraint other
                                       WHERE other.conrelid = c.conrelid AND other.contype = 'f'
                                         AND other.confrelid = 'users'::regclass))
            ORDER BY table_name, column_name)sql",
           std::string(to), without_users)) {
    found.push_back({row["table_name"].as<std::string>(), row["column_name"].as<std::string>()});
  }
  return found;
}

/// Returns the rows of a table (name quoted, from the catalogue) as a JSON array without secrets.
ExportSection rows(pqxx::work& transaction, const Belonging& of, const std::string& where,
                   const std::string& user_id) {
  const std::string query =
      "SELECT COALESCE(json_agg((SELECT json_object_agg(key, value) FROM jsonb_each(to_jsonb(t)) "
      "WHERE key !~ '(_hash|token|secret)$')), '[]')::text AS rows FROM " +
      of.table + " t WHERE " + where;
  return {"records/" + of.table + "." + of.column + ".json",
          transaction.exec_params1(query, user_id)["rows"].as<std::string>()};
}

}  // namespace

Result<bool> PrivacyRepository::request(const std::string& user_id, const Export& requested,
                                        Time not_since) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result gone = transaction.exec_params(R"sql(
        WITH old AS (
          DELETE FROM exports
           WHERE user_id = $1::uuid AND (state = 'failed' OR created_at <= to_timestamp($2::bigint / 1e6))
          RETURNING id)
        INSERT INTO disposals (kind, id) SELECT 'export', id FROM old ON CONFLICT DO NOTHING)sql",
                                                      user_id, to_us(not_since));
    const pqxx::result made = transaction.exec_params(
        R"sql(
        INSERT INTO exports (id, user_id, state, created_at, expires_at)
        VALUES ($1::uuid, $2::uuid, 'queued', to_timestamp($3::bigint / 1e6), to_timestamp($4::bigint / 1e6))
        ON CONFLICT (user_id) DO NOTHING)sql",
        requested.id, user_id, to_us(requested.created_at), to_us(requested.expires_at));
    if (made.affected_rows() == 0) return false;
    note_in_audit_log(
        transaction, {AuditActor::kPerson, user_id, "account.export-asked", "account", user_id, {}},
        requested.created_at);
    return true;
  });
}

Result<std::optional<Export>> PrivacyRepository::find(const std::string& user_id, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::optional<Export>> {
    const pqxx::result found = transaction.exec_params(
        R"sql(
        SELECT id, state, COALESCE(bytes, 0) AS bytes, (extract(epoch FROM created_at) * 1000000)::bigint AS created_us,
               (extract(epoch FROM expires_at) * 1000000)::bigint AS expires_us, waiting
          FROM exports WHERE user_id = $1::uuid AND expires_at > to_timestamp($2::bigint / 1e6))sql",
        user_id, to_us(now));
    if (found.empty()) return std::nullopt;
    const auto state = found[0]["state"].as<std::string>();
    return Export{found[0]["id"].as<std::string>(),
                  state == "ready"    ? Export::State::kReady
                  : state == "failed" ? Export::State::kFailed
                                      : Export::State::kQueued,
                  found[0]["bytes"].as<std::int64_t>(),
                  from_us(found[0]["created_us"].as<std::int64_t>()),
                  from_us(found[0]["expires_us"].as<std::int64_t>()),
                  found[0]["waiting"].as<bool>()};
  });
}

Result<bool> PrivacyRepository::remove(const std::string& user_id, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result gone = transaction.exec_params(
        R"sql(
        WITH old AS (DELETE FROM exports WHERE user_id = $1::uuid RETURNING id)
        INSERT INTO disposals (kind, id, created_at)
        SELECT 'export', id, to_timestamp($2::bigint / 1e6) FROM old)sql",
        user_id, to_us(now));
    return gone.affected_rows() > 0;
  });
}

Result<std::optional<ExportStore::Job>> PrivacyRepository::claim(Time now,
                                                                 std::chrono::seconds lease) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::optional<Job>> {
    transaction.exec_params0(R"sql(
        UPDATE exports SET state = 'failed'
         WHERE state = 'queued' AND attempts >= $2 AND leased_until <= to_timestamp($1::bigint / 1e6))sql",
                             to_us(now), kExportAttempts);
    const pqxx::result claimed = transaction.exec_params(
        R"sql(
        UPDATE exports SET attempts = attempts + 1, leased_until = to_timestamp($2::bigint / 1e6)
         WHERE id = (SELECT id FROM exports
                      WHERE state = 'queued'
                        AND (leased_until IS NULL OR leased_until <= to_timestamp($1::bigint / 1e6))
                        AND (not_before IS NULL OR not_before <= to_timestamp($1::bigint / 1e6))
                      ORDER BY created_at LIMIT 1 FOR UPDATE SKIP LOCKED)
        RETURNING id, user_id, waits)sql",
        to_us(now), to_us(now + lease));
    if (claimed.empty()) return std::nullopt;
    return Job{claimed[0]["id"].as<std::string>(), claimed[0]["user_id"].as<std::string>(),
               claimed[0]["waits"].as<int>()};
  });
}

Result<std::vector<ExportSection>> PrivacyRepository::sections(const std::string& user_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<ExportSection>> {
    std::vector<ExportSection> sections;
    sections.push_back(rows(transaction, {"users", "id"}, "t.id = $1::uuid", user_id));
    for (const Belonging& of : belongings(transaction, "users", false)) {
      sections.push_back(
          rows(transaction, of, "t." + transaction.quote_name(of.column) + " = $1::uuid", user_id));
    }
    for (const Belonging& of : belongings(transaction, "data_sets", true)) {
      sections.push_back(rows(transaction, of,
                              "t." + transaction.quote_name(of.column) +
                                  " IN (SELECT id FROM data_sets WHERE owner_id = $1::uuid)",
                              user_id));
    }
    for (const pqxx::row& row : transaction.exec_params(
             R"sql(
             SELECT a.data_set_id, json_agg(json_build_object(
                      'name', a.name, 'shown', a.shown, 'shared', a.shared, 'created_at', a.created_at,
                      'updated_at', a.updated_at, 'content', a.content::json)
                      ORDER BY a.created_at, a.id)::text AS sets
               FROM annotations a JOIN data_sets d ON d.id = a.data_set_id
              WHERE a.author_id = $1::uuid AND d.owner_id = $1::uuid
              GROUP BY a.data_set_id)sql",
             user_id)) {
      sections.push_back({"scans/" + row["data_set_id"].as<std::string>() + "/marks.json",
                          row["sets"].as<std::string>()});
    }
    // Replaces actor IDs with by_you, which hides the identity of other actors.
    sections.push_back({"audit.json", transaction
                                          .exec_params1(R"sql(
        SELECT COALESCE(json_agg(json_build_object(
                 'happened_at', happened_at, 'by', actor, 'by_you', actor_id = $1::uuid, 'action', action,
                 'subject', subject, 'subject_id', subject_id, 'details', details) ORDER BY id), '[]')::text AS entries
          FROM audit_log
         WHERE actor_id = $1::uuid OR subject_id = $1::uuid
            OR subject_id IN (SELECT id FROM data_sets WHERE owner_id = $1::uuid
                               UNION ALL SELECT id FROM presets WHERE author_id = $1::uuid))sql",
                                                        user_id)["entries"]
                                          .as<std::string>()});
    return sections;
  });
}

Result<std::vector<std::string>> PrivacyRepository::volumes(const std::string& user_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<std::string>> {
    std::vector<std::string> ids;
    for (const pqxx::row& row :
         transaction.exec_params("SELECT id FROM data_sets WHERE owner_id = $1::uuid AND state = "
                                 "'ready' ORDER BY created_at",
                                 user_id)) {
      ids.push_back(row["id"].as<std::string>());
    }
    return ids;
  });
}

Result<std::vector<std::string>> PrivacyRepository::environments(const std::string& user_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<std::string>> {
    std::vector<std::string> ids;
    for (const pqxx::row& row : transaction.exec_params(
             "SELECT id FROM environments WHERE owner_id = $1::uuid ORDER BY created_at",
             user_id)) {
      ids.push_back(row["id"].as<std::string>());
    }
    return ids;
  });
}

Result<std::vector<ExportStore::Picture>> PrivacyRepository::pictures(const std::string& user_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<Picture>> {
    std::vector<Picture> found;
    for (const pqxx::row& row : transaction.exec_params(
             R"sql(
             SELECT d.id AS data_set_id, p.id AS preset_id FROM data_sets d JOIN presets p ON p.data_set_id = d.id
              WHERE d.owner_id = $1::uuid AND d.state = 'ready' AND p.pictured_at IS NOT NULL
              ORDER BY d.created_at, p.created_at)sql",
             user_id)) {
      found.push_back({row["data_set_id"].as<std::string>(), row["preset_id"].as<std::string>()});
    }
    return found;
  });
}

Result<void> PrivacyRepository::note_download(const std::string& user_id, const Client& client,
                                              Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    std::vector<std::string> scans;
    for (const pqxx::row& row : transaction.exec_params(
             R"sql(
             SELECT d.id FROM data_sets d JOIN exports e ON e.user_id = d.owner_id
              WHERE d.owner_id = $1::uuid AND d.state = 'ready' AND d.created_at <= e.created_at)sql",
             user_id)) {
      scans.push_back(row["id"].as<std::string>());
    }
    note_views(transaction, scans, {ViewRoute::kExport, user_id, "", client}, now);
    note_once_in_audit_log(
        transaction,
        {AuditActor::kPerson, user_id, "account.export-downloaded", "account", user_id, {}},
        now - kSameView, now);
    return {};
  });
}

Result<bool> PrivacyRepository::finish(const std::string& id, std::int64_t bytes) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result done = transaction.exec_params(
        "UPDATE exports SET state = 'ready', bytes = $2 WHERE id = $1::uuid AND state = 'queued'",
        id, bytes);
    return done.affected_rows() > 0;
  });
}

Result<ExportStore::Sizes> PrivacyRepository::sizes(const std::string& user_id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<Sizes> {
    const pqxx::row row = transaction.exec_params1(
        R"sql(
        SELECT COALESCE((SELECT sum(volume_bytes + label_bytes) FROM data_sets
                          WHERE owner_id = $1::uuid AND state = 'ready'), 0)::bigint AS volume_bytes,
               (COALESCE((SELECT sum(bytes) FROM exports WHERE state = 'ready'), 0)
              + COALESCE((SELECT sum(bytes) FROM scan_exports), 0))::bigint AS export_bytes)sql",
        user_id);
    return Sizes{row["volume_bytes"].as<std::int64_t>(), row["export_bytes"].as<std::int64_t>()};
  });
}

Result<void> PrivacyRepository::wait(const std::string& id, Time not_before) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    // An export must not expire while it waits.
    transaction.exec_params0(
        R"sql(
        UPDATE exports
           SET leased_until = NULL, attempts = attempts - 1, waits = waits + 1, waiting = true,
               not_before = to_timestamp($2::bigint / 1e6),
               expires_at = GREATEST(expires_at, to_timestamp($2::bigint / 1e6) + interval '1 day')
         WHERE id = $1::uuid AND state = 'queued')sql",
        id, to_us(not_before));
    return {};
  });
}

Result<void> PrivacyRepository::expire(Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(
        R"sql(
        WITH old AS (DELETE FROM exports WHERE expires_at <= to_timestamp($1::bigint / 1e6) RETURNING id)
        INSERT INTO disposals (kind, id, created_at)
        SELECT 'export', id, to_timestamp($1::bigint / 1e6) FROM old ON CONFLICT DO NOTHING)sql",
        to_us(now));
    return {};
  });
}

Result<std::vector<std::string>> PrivacyRepository::ids() {
  return database_.read([](pqxx::work& transaction) -> Result<std::vector<std::string>> {
    std::vector<std::string> all;
    for (const pqxx::row& row :
         transaction.exec("SELECT id FROM exports UNION ALL SELECT id FROM scan_exports")) {
      all.push_back(row["id"].as<std::string>());
    }
    return all;
  });
}

Result<std::vector<std::string>> PrivacyRepository::remove_account(
    const std::string& user_id, const std::string& email,
    const std::vector<std::string>& attempt_keys, const Mail& notification, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::vector<std::string>> {
    transaction.exec_params("SELECT id FROM users WHERE id = $1::uuid FOR UPDATE", user_id);
    std::vector<std::string> data_sets;
    for (const pqxx::row& row : transaction.exec_params(
             "SELECT id FROM data_sets WHERE owner_id = $1::uuid FOR UPDATE", user_id)) {
      data_sets.push_back(row["id"].as<std::string>());
    }
    transaction.exec_params0(
        R"sql(
        INSERT INTO disposals (kind, id, created_at)
        SELECT kind, id, to_timestamp($2::bigint / 1e6)
          FROM data_sets CROSS JOIN (VALUES ('upload'), ('volume')) AS kinds (kind)
         WHERE owner_id = $1::uuid
        UNION ALL SELECT 'export', id, to_timestamp($2::bigint / 1e6) FROM exports WHERE user_id = $1::uuid
        ON CONFLICT DO NOTHING)sql",
        user_id, to_us(now));
    transaction.exec_params0(
        R"sql(
        UPDATE audit_log
           SET actor_id = CASE WHEN actor_id = $1::uuid THEN NULL ELSE actor_id END,
               subject_id = CASE WHEN subject_id = $1::uuid
                                   OR subject_id IN (SELECT id FROM data_sets WHERE owner_id = $1::uuid
                               UNION ALL SELECT id FROM presets WHERE author_id = $1::uuid)
                                 THEN NULL ELSE subject_id END
         WHERE actor_id = $1::uuid OR subject_id = $1::uuid
            OR subject_id IN (SELECT id FROM data_sets WHERE owner_id = $1::uuid
                               UNION ALL SELECT id FROM presets WHERE author_id = $1::uuid))sql",
        user_id);
    forget_viewer(transaction, user_id);
    // A report may remain, but without the reporter's words.
    transaction.exec_params0("UPDATE reports SET words = '' WHERE reporter_id = $1::uuid", user_id);
    note_in_audit_log(transaction,
                      {AuditActor::kPerson,
                       "",
                       "account.deleted",
                       "account",
                       "",
                       {{"data_sets", static_cast<std::int64_t>(data_sets.size())}}},
                      now);
    for (const std::string& key : attempt_keys) {
      transaction.exec_params0("DELETE FROM attempts WHERE key_hash = $1", key);
    }
    transaction.exec_params0("DELETE FROM mail_queue WHERE lower(recipient) = lower($1)", email);
    queue_mail(transaction, notification, now);
    // Deletes all other rows of the account, too (ON DELETE CASCADE).
    transaction.exec_params0("DELETE FROM users WHERE id = $1::uuid", user_id);
    return data_sets;
  });
}

}  // namespace diaphane::api
