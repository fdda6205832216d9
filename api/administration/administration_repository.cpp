#include "api/administration/administration_repository.h"

#include "api/accounts/account_repository.h"
#include "api/shared/audit_repository.h"

namespace diaphane::api {
namespace {

// Selects accounts at the time $1. Counts the used bytes in the same way as `lock_quota`.
constexpr const char* kSelectUser = R"sql(
  SELECT u.id, u.email, (extract(epoch FROM u.created_at) * 1000000)::bigint AS created_us,
         (SELECT (extract(epoch FROM max(s.used_at)) * 1000000)::bigint FROM web_sessions s WHERE s.user_id = u.id) AS used_us,
         u.verified_at IS NOT NULL AS verified, u.disabled_at IS NOT NULL AS disabled, u.is_administrator,
         u.is_researcher, u.archive_access, u.quota_bytes,
         COALESCE((SELECT sum(COALESCE(d.volume_bytes, 0) + d.label_bytes + COALESCE(up.length, 0))
                            FILTER (WHERE d.state IN ('uploading', 'queued', 'building', 'ready'))
                     FROM data_sets d LEFT JOIN uploads up ON up.data_set_id = d.id
                    WHERE d.owner_id = u.id), 0)::bigint AS used_bytes,
         u.render_quota_ms,
         COALESCE((SELECT r.device_ms FROM render_time r
                    WHERE r.user_id = u.id
                      AND r.month = date_trunc('month', to_timestamp($1::bigint / 1e6) AT TIME ZONE 'UTC')::date), 0) AS render_used_ms,
         (SELECT count(*) FROM data_sets d WHERE d.owner_id = u.id)::int AS data_sets
    FROM users u)sql";

UserRecord read_user(const pqxx::row& row) {
  UserRecord user;
  user.id = row["id"].as<std::string>();
  user.email = row["email"].as<std::string>();
  user.created_at = from_us(row["created_us"].as<std::int64_t>());
  if (!row["used_us"].is_null()) user.used_at = from_us(row["used_us"].as<std::int64_t>());
  user.verified = row["verified"].as<bool>();
  user.disabled = row["disabled"].as<bool>();
  user.administrator = row["is_administrator"].as<bool>();
  user.researcher = row["is_researcher"].as<bool>();
  user.archive_access = row["archive_access"].as<bool>();
  user.storage = {row["quota_bytes"].as<std::int64_t>(), row["used_bytes"].as<std::int64_t>()};
  user.render_quota_ms = row["render_quota_ms"].as<std::int64_t>();
  user.render_used_ms = row["render_used_ms"].as<std::int64_t>();
  user.data_sets = row["data_sets"].as<int>();
  return user;
}

/// Closes the open studies of a researcher. The background task ends the sessions of participants.
void close_studies(pqxx::work& transaction, const std::string& id, Time now) {
  for (const pqxx::row& row : transaction.exec_params(
           R"sql(
           UPDATE studies SET state = 'closed', closed_at = to_timestamp($2::bigint / 1e6)
            WHERE owner_id = $1::uuid AND state = 'open' RETURNING id)sql",
           id, to_us(now))) {
    note_in_audit_log(
        transaction,
        {AuditActor::kMachine, "", "study.closed", "study", row[0].as<std::string>(), {}}, now);
  }
}

std::string text_or_empty(const pqxx::field& field) {
  return field.is_null() ? std::string() : field.as<std::string>();
}

}  // namespace

Result<std::vector<UserRecord>> AdministrationRepository::users(const std::string& part,
                                                                const std::optional<Cursor>& after,
                                                                int limit, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<UserRecord>> {
    std::vector<UserRecord> users;
    for (const pqxx::row& row :
         transaction.exec_params(std::string(kSelectUser) + R"sql(
              WHERE ($2 = '' OR strpos(u.email_key, lower($2)) > 0 OR u.id::text = lower($2))
                AND ($5::bool OR (u.created_at, u.id) < (to_timestamp($3::bigint / 1e6), $4::uuid))
              ORDER BY u.created_at DESC, u.id DESC LIMIT $6)sql",
                                 to_us(now), part, after ? after->created_us : std::int64_t{0},
                                 after ? after->id.c_str() : nullptr, !after.has_value(), limit)) {
      users.push_back(read_user(row));
    }
    return users;
  });
}

Result<std::optional<UserRecord>> AdministrationRepository::user(const std::string& id, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::optional<UserRecord>> {
    const pqxx::result found = transaction.exec_params(
        std::string(kSelectUser) + " WHERE u.id = $2::uuid", to_us(now), id);
    if (found.empty()) return std::nullopt;
    return read_user(found[0]);
  });
}

Result<bool> AdministrationRepository::change(const std::string& administrator_id,
                                              const std::string& id, const UserChange& change,
                                              Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result before = transaction.exec_params(R"sql(
        SELECT quota_bytes, render_quota_ms, disabled_at IS NOT NULL AS disabled, is_researcher,
               archive_access FROM users
         WHERE id = $1::uuid FOR UPDATE)sql",
                                                        id);
    if (before.empty()) return false;
    const auto note = [&](std::string action, std::vector<AuditDetail> details) {
      note_in_audit_log(transaction,
                        {AuditActor::kAdministrator, administrator_id, std::move(action), "account",
                         id, std::move(details)},
                        now);
    };
    const auto old_bytes = before[0]["quota_bytes"].as<std::int64_t>();
    const auto old_ms = before[0]["render_quota_ms"].as<std::int64_t>();
    if (change.quota_bytes && *change.quota_bytes != old_bytes) {
      transaction.exec_params0("UPDATE users SET quota_bytes = $2 WHERE id = $1::uuid", id,
                               *change.quota_bytes);
      note("account.storage-quota-changed", {{"from", old_bytes}, {"to", *change.quota_bytes}});
    }
    if (change.render_quota_ms && *change.render_quota_ms != old_ms) {
      transaction.exec_params0("UPDATE users SET render_quota_ms = $2 WHERE id = $1::uuid", id,
                               *change.render_quota_ms);
      // A new quota resets the warning about the old one.
      transaction.exec_params0("UPDATE render_time SET warned_at = NULL WHERE user_id = $1::uuid",
                               id);
      note("account.render-quota-changed", {{"from", old_ms}, {"to", *change.render_quota_ms}});
    }
    if (change.disabled && *change.disabled != before[0]["disabled"].as<bool>()) {
      transaction.exec_params0(R"sql(
          UPDATE users SET disabled_at = CASE WHEN $2 THEN to_timestamp($3::bigint / 1e6) END
           WHERE id = $1::uuid)sql",
                               id, *change.disabled, to_us(now));
      if (*change.disabled) {
        expire_sessions(transaction, id);
        transaction.exec_params0("DELETE FROM email_tokens WHERE user_id = $1::uuid", id);
      }
      note(*change.disabled ? "account.disabled" : "account.enabled", {});
    }
    if (change.researcher && *change.researcher != before[0]["is_researcher"].as<bool>()) {
      transaction.exec_params0("UPDATE users SET is_researcher = $2 WHERE id = $1::uuid", id,
                               *change.researcher);
      note(*change.researcher ? "researcher.granted" : "researcher.revoked", {});
    }
    if (change.archive_access && *change.archive_access != before[0]["archive_access"].as<bool>()) {
      transaction.exec_params0("UPDATE users SET archive_access = $2 WHERE id = $1::uuid", id,
                               *change.archive_access);
      note(*change.archive_access ? "archive-access.granted" : "archive-access.revoked", {});
    }
    if (change.disabled.value_or(false) || !change.researcher.value_or(true)) {
      close_studies(transaction, id, now);
    }
    return true;
  });
}

Result<bool> AdministrationRepository::set_administrator(const std::string& email_key, bool granted,
                                                         Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result changed = transaction.exec_params(
        R"sql(
        UPDATE users SET is_administrator = $2 WHERE email_key = $1 AND verified_at IS NOT NULL
        RETURNING id)sql",
        email_key, granted);
    if (changed.empty()) return false;
    note_in_audit_log(transaction,
                      {AuditActor::kMachine,
                       "",
                       granted ? "administrator.granted" : "administrator.revoked",
                       "account",
                       changed[0]["id"].as<std::string>(),
                       {}},
                      now);
    return true;
  });
}

Result<std::vector<Administrator>> AdministrationRepository::administrators() {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<Administrator>> {
    std::vector<Administrator> all;
    for (const pqxx::row& row : transaction.exec(R"sql(
             SELECT u.email, f.confirmed_at IS NOT NULL AS second_factor
               FROM users u LEFT JOIN second_factors f ON f.user_id = u.id
              WHERE u.is_administrator ORDER BY u.email)sql")) {
      all.push_back({row["email"].as<std::string>(), row["second_factor"].as<bool>()});
    }
    return all;
  });
}

Result<void> AdministrationRepository::note(const AuditEntry& entry, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    note_in_audit_log(transaction, entry, now);
    return {};
  });
}

Result<std::vector<AuditRecord>> AdministrationRepository::audit(const AuditFilter& filter) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<AuditRecord>> {
    const auto us = [](const std::optional<Time>& time, std::int64_t otherwise) {
      return time ? to_us(*time) : otherwise;
    };
    std::vector<AuditRecord> records;
    for (const pqxx::row& row : transaction.exec_params(
             R"sql(
             SELECT a.id, (extract(epoch FROM a.happened_at) * 1000000)::bigint AS happened_us, a.actor, a.actor_id,
                    a.action, a.subject, a.subject_id, a.details::text AS details, by.email AS actor_email,
                    of.email AS subject_email
               FROM audit_log a
               LEFT JOIN users by ON by.id = a.actor_id
               LEFT JOIN users of ON of.id = a.subject_id
              WHERE ($1::uuid IS NULL OR a.actor_id = $1::uuid OR a.subject_id = $1::uuid)
                AND starts_with(a.action, $2)
                AND a.happened_at >= to_timestamp($3::bigint / 1e6)
                AND a.happened_at < to_timestamp($4::bigint / 1e6)
                AND a.id < $5::bigint
              ORDER BY a.id DESC LIMIT $6)sql",
             filter.account_id.empty() ? nullptr : filter.account_id.c_str(), filter.action,
             us(filter.from, 0), us(filter.until, std::int64_t{32503680000} * 1'000'000),
             filter.before_id.value_or(INT64_MAX), filter.limit)) {
      records.push_back({row["id"].as<std::int64_t>(),
                         from_us(row["happened_us"].as<std::int64_t>()),
                         row["actor"].as<std::string>(), text_or_empty(row["actor_id"]),
                         row["action"].as<std::string>(), row["subject"].as<std::string>(),
                         text_or_empty(row["subject_id"]), row["details"].as<std::string>(),
                         text_or_empty(row["actor_email"]), text_or_empty(row["subject_email"])});
    }
    return records;
  });
}

Result<std::vector<std::string>> AdministrationRepository::ready_data_sets(
    const std::string& user_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<std::string>> {
    std::vector<std::string> found;
    for (const pqxx::row& row : transaction.exec_params(
             "SELECT id FROM data_sets WHERE owner_id = $1::uuid AND state = 'ready'", user_id)) {
      found.push_back(row["id"].as<std::string>());
    }
    return found;
  });
}

Result<IngestQueue> AdministrationRepository::ingest_queue() {
  return database_.read([&](pqxx::work& transaction) -> Result<IngestQueue> {
    const pqxx::row row = transaction.exec1(R"sql(
        SELECT count(*) FILTER (WHERE state = 'queued')::int AS queued,
               count(*) FILTER (WHERE state = 'building')::int AS building
          FROM data_sets WHERE state IN ('queued', 'building'))sql");
    return IngestQueue{row["queued"].as<int>(), row["building"].as<int>()};
  });
}

}  // namespace diaphane::api
