#include "api/accounts/account_repository.h"

#include <algorithm>

#include "api/shared/audit_repository.h"

namespace diaphane::api {
namespace {

constexpr const char* kUsedBytes = R"sql(
  SELECT COALESCE(sum(COALESCE(d.volume_bytes, 0) + d.label_bytes + COALESCE(u.length, 0))
           FILTER (WHERE d.state IN ('uploading', 'queued', 'building', 'ready')), 0)::bigint AS used_bytes
    FROM data_sets d LEFT JOIN uploads u ON u.data_set_id = d.id
   WHERE d.owner_id = $1)sql";

std::optional<Account> read_account(const pqxx::result& found) {
  if (found.empty()) return std::nullopt;
  return Account{found[0]["id"].as<std::string>(), found[0]["email"].as<std::string>(),
                 found[0]["password_hash"].as<std::string>(), found[0]["verified"].as<bool>(),
                 found[0]["disabled"].as<bool>()};
}

}  // namespace

void expire_sessions(pqxx::work& transaction, const std::string& user_id,
                     const std::string& kept_session) {
  transaction.exec_params0(R"sql(
      UPDATE web_sessions SET expires_at = 'epoch'
       WHERE user_id = $1::uuid AND ($2 = '' OR id <> NULLIF($2, '')::uuid))sql",
                           user_id, kept_session);
  transaction.exec_params0("UPDATE api_tokens SET expires_at = 'epoch' WHERE user_id = $1::uuid",
                           user_id);
}

void queue_mail(pqxx::work& transaction, const Mail& mail, Time now) {
  transaction.exec_params0(R"sql(
      INSERT INTO mail_queue (recipient, subject, body, not_before)
      VALUES ($1, $2, $3, to_timestamp($4::bigint / 1e6)))sql",
                           mail.recipient, mail.subject, mail.body, to_us(now));
}

Quota lock_quota(pqxx::work& transaction, const std::string& user_id) {
  const pqxx::row user =
      transaction.exec_params1("SELECT quota_bytes FROM users WHERE id = $1 FOR UPDATE", user_id);
  return {user["quota_bytes"].as<std::int64_t>(),
          transaction.exec_params1(kUsedBytes, user_id)["used_bytes"].as<std::int64_t>()};
}

Result<void> AccountRepository::sign_up(const SignUp& sign_up, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(
        R"sql(
        WITH account AS (
          INSERT INTO users AS u (id, email, email_key, created_at, consent_version, consent_at)
          VALUES ($1, $2, $3, to_timestamp($6::bigint / 1e6), $12, to_timestamp($6::bigint / 1e6))
          ON CONFLICT (email_key) DO UPDATE
             SET email = excluded.email, created_at = excluded.created_at,
                 consent_version = excluded.consent_version, consent_at = excluded.consent_at
           WHERE u.verified_at IS NULL
          RETURNING id),
        token AS (
          INSERT INTO email_tokens (token_hash, user_id, purpose, expires_at)
          SELECT $4, id, 'verify', to_timestamp($5::bigint / 1e6) FROM account)
        INSERT INTO mail_queue (recipient, subject, body, not_before)
        SELECT $7, CASE WHEN is_open THEN $8 ELSE $10 END, CASE WHEN is_open THEN $9 ELSE $11 END,
               to_timestamp($6::bigint / 1e6)
          FROM (SELECT EXISTS (SELECT FROM account) AS is_open) AS made)sql",
        sign_up.user_id, sign_up.email, sign_up.email_key, sign_up.token_hash,
        to_us(sign_up.token_expires_at), to_us(now), sign_up.welcome.recipient,
        sign_up.welcome.subject, sign_up.welcome.body, sign_up.already_there.subject,
        sign_up.already_there.body, sign_up.consent_version);
    return {};
  });
}

Result<std::optional<std::string>> AccountRepository::find_sign_up(const std::string& token_hash,
                                                                   Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::optional<std::string>> {
    const pqxx::result found = transaction.exec_params(
        R"sql(
        SELECT u.email FROM email_tokens t JOIN users u ON u.id = t.user_id
         WHERE t.token_hash = $1 AND t.purpose = 'verify' AND u.verified_at IS NULL
           AND t.expires_at > to_timestamp($2::bigint / 1e6))sql",
        token_hash, to_us(now));
    if (found.empty()) return std::nullopt;
    return found[0]["email"].as<std::string>();
  });
}

Result<bool> AccountRepository::verify(const std::string& token_hash,
                                       const std::string& password_hash, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result verified = transaction.exec_params(
        R"sql(
        UPDATE users SET verified_at = to_timestamp($3::bigint / 1e6), password_hash = $2
          FROM email_tokens t
         WHERE users.id = t.user_id AND users.verified_at IS NULL
           AND t.token_hash = $1 AND t.purpose = 'verify'
           AND t.expires_at > to_timestamp($3::bigint / 1e6)
        RETURNING users.id)sql",
        token_hash, password_hash, to_us(now));
    if (verified.empty()) return false;
    transaction.exec_params0("DELETE FROM email_tokens WHERE user_id = $1",
                             verified[0]["id"].as<std::string>());
    return true;
  });
}

Result<std::optional<Account>> AccountRepository::find_by_email(const std::string& email_key) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::optional<Account>> {
    return read_account(transaction.exec_params(R"sql(
        SELECT id, email, password_hash, verified_at IS NOT NULL AS verified,
               disabled_at IS NOT NULL AS disabled
          FROM users WHERE email_key = $1)sql",
                                                email_key));
  });
}

Result<std::optional<Account>> AccountRepository::find_by_id(const std::string& user_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::optional<Account>> {
    return read_account(transaction.exec_params(R"sql(
        SELECT id, email, password_hash, verified_at IS NOT NULL AS verified,
               disabled_at IS NOT NULL AS disabled
          FROM users WHERE id = $1::uuid)sql",
                                                user_id));
  });
}

Result<void> AccountRepository::open_session(const WebSession& session) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(R"sql(
        INSERT INTO web_sessions (token_hash, user_id, csrf_token, created_at, used_at, expires_at, id, browser)
        VALUES ($1, $2, $3, to_timestamp($4::bigint / 1e6), to_timestamp($4::bigint / 1e6),
                to_timestamp($5::bigint / 1e6), $6::uuid, $7))sql",
                             session.token_hash, session.user_id, session.csrf_token,
                             to_us(session.created_at), to_us(session.expires_at), session.id,
                             session.browser);
    return {};
  });
}

Result<std::optional<SignedIn>> AccountRepository::find_session(const std::string& token_hash,
                                                                Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::optional<SignedIn>> {
    const pqxx::result found = transaction.exec_params(R"sql(
        SELECT s.user_id, s.csrf_token, u.email,
               (extract(epoch FROM s.created_at) * 1000000)::bigint AS created_us,
               (extract(epoch FROM s.expires_at) * 1000000)::bigint AS expires_us, s.id, s.browser,
               u.is_administrator, u.is_researcher, u.archive_access, (extract(epoch FROM s.used_at) * 1000000)::bigint AS used_us,
               EXISTS (SELECT FROM second_factors f
                        WHERE f.user_id = u.id AND f.confirmed_at IS NOT NULL) AS second_factor,
               coalesce(u.consent_version, '') AS consent_version
          FROM web_sessions s JOIN users u ON u.id = s.user_id
         WHERE s.token_hash = $1 AND s.expires_at > to_timestamp($2::bigint / 1e6)
           AND u.verified_at IS NOT NULL AND u.disabled_at IS NULL)sql",
                                                       token_hash, to_us(now));
    if (found.empty()) return std::nullopt;
    const pqxx::row row = found[0];
    return SignedIn{
        {token_hash, row["user_id"].as<std::string>(), row["csrf_token"].as<std::string>(),
         from_us(row["created_us"].as<std::int64_t>()),
         from_us(row["expires_us"].as<std::int64_t>()), row["id"].as<std::string>(),
         row["browser"].as<std::string>()},
        row["email"].as<std::string>(),
        row["is_administrator"].as<bool>(),
        from_us(row["used_us"].as<std::int64_t>()),
        row["second_factor"].as<bool>(),
        row["consent_version"].as<std::string>(),
        row["is_researcher"].as<bool>(),
        row["archive_access"].as<bool>()};
  });
}

Result<void> AccountRepository::extend_session(const std::string& token_hash, Time expires_at) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(
        // Leaves out a session that was signed out after this request was authenticated.
        "UPDATE web_sessions SET expires_at = to_timestamp($2::bigint / 1e6) "
        "WHERE token_hash = $1 AND expires_at > 'epoch'",
        token_hash, to_us(expires_at));
    return {};
  });
}

Result<void> AccountRepository::touch_session(const std::string& token_hash, Time used_at) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(
        "UPDATE web_sessions SET used_at = to_timestamp($2::bigint / 1e6) WHERE token_hash = $1",
        token_hash, to_us(used_at));
    return {};
  });
}

Result<void> AccountRepository::close_session(const std::string& token_hash) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0("UPDATE web_sessions SET expires_at = 'epoch' WHERE token_hash = $1",
                             token_hash);
    return {};
  });
}

Result<Quota> AccountRepository::quota_of(const std::string& user_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<Quota> {
    const auto limit =
        transaction.exec_params("SELECT quota_bytes FROM users WHERE id = $1", user_id);
    if (limit.empty()) return fail(ErrorCode::kNotFound, "Account not found.");
    return Quota{limit[0]["quota_bytes"].as<std::int64_t>(),
                 transaction.exec_params1(kUsedBytes, user_id)["used_bytes"].as<std::int64_t>()};
  });
}

Result<std::optional<Time>> AccountRepository::consent_at(const std::string& user_id,
                                                          const std::string& version) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::optional<Time>> {
    const pqxx::result rows = transaction.exec_params(R"sql(
        SELECT (extract(epoch FROM consent_at) * 1000000)::bigint AS consent_us
          FROM users WHERE id = $1::uuid AND consent_version = $2)sql",
                                                      user_id, version);
    if (rows.empty()) return std::nullopt;
    return from_us(rows[0]["consent_us"].as<std::int64_t>());
  });
}

Result<void> AccountRepository::give_consent(const std::string& user_id, const std::string& version,
                                             Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(R"sql(
        UPDATE users SET consent_version = $2, consent_at = to_timestamp($3::bigint / 1e6)
         WHERE id = $1::uuid)sql",
                             user_id, version, to_us(now));
    note_in_audit_log(transaction,
                      {AuditActor::kPerson,
                       user_id,
                       "account.consent-given",
                       "account",
                       user_id,
                       {{"version", version}}},
                      now);
    return {};
  });
}

Result<std::optional<std::chrono::seconds>> AccountRepository::note_attempt(
    const std::vector<AttemptLimit>& limits, Time now) {
  // Rows are always locked in the same order to avoid deadlocks.
  std::vector<AttemptLimit> ordered = limits;
  std::sort(ordered.begin(), ordered.end(),
            [](const auto& a, const auto& b) { return a.key_hash < b.key_hash; });
  using Wait = std::optional<std::chrono::seconds>;
  return database_.transact([&](pqxx::work& transaction) -> Result<Wait> {
    Wait wait;
    for (const AttemptLimit& limit : ordered) {
      transaction.exec_params1("SELECT pg_advisory_xact_lock(hashtextextended($1, 0))::text",
                               limit.key_hash);
      // The next attempt is allowed once the count-th newest attempt leaves the window.
      const pqxx::result blocking = transaction.exec_params(
          R"sql(
          SELECT (extract(epoch FROM happened_at) * 1000000)::bigint AS happened_us
            FROM attempts
           WHERE key_hash = $1 AND happened_at > to_timestamp($2::bigint / 1e6)
           ORDER BY happened_at DESC OFFSET $3::int - 1 LIMIT 1)sql",
          limit.key_hash, to_us(now - limit.window), limit.count);
      if (blocking.empty()) continue;
      const Time free_at = from_us(blocking[0]["happened_us"].as<std::int64_t>()) + limit.window;
      wait = std::max(wait.value_or(std::chrono::seconds(1)),
                      std::chrono::ceil<std::chrono::seconds>(free_at - now));
    }
    if (wait) return wait;
    for (const AttemptLimit& limit : ordered) {
      transaction.exec_params0(
          "INSERT INTO attempts (key_hash, happened_at) VALUES ($1, to_timestamp($2::bigint / "
          "1e6))",
          limit.key_hash, to_us(now));
    }
    return wait;
  });
}

Result<void> AccountRepository::forget_attempts(const std::string& key_hash,
                                                std::optional<Time> at) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    if (at) {
      transaction.exec_params0(R"sql(
          DELETE FROM attempts
           WHERE key_hash = $1 AND happened_at = to_timestamp($2::bigint / 1e6))sql",
                               key_hash, to_us(*at));
    } else {
      transaction.exec_params0("DELETE FROM attempts WHERE key_hash = $1", key_hash);
    }
    return {};
  });
}

Result<void> AccountRepository::tidy(Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    const std::int64_t us = to_us(now);
    transaction.exec_params0(
        "DELETE FROM attempts WHERE happened_at < to_timestamp($1::bigint / 1e6) - interval '1 "
        "day'",
        us);
    transaction.exec_params0(
        "DELETE FROM email_tokens WHERE expires_at < to_timestamp($1::bigint / 1e6)", us);
    transaction.exec_params0(R"sql(
        DELETE FROM idempotency_keys
         WHERE created_at < to_timestamp($1::bigint / 1e6) - interval '2 days')sql",
                             us);
    transaction.exec_params0(R"sql(
        DELETE FROM audit_log
         WHERE happened_at < to_timestamp($1::bigint / 1e6) - interval '366 days'
           AND happened_at < now() - interval '365 days')sql",
                             us);
    transaction.exec_params0(R"sql(
        DELETE FROM render_time
         WHERE month < to_timestamp($1::bigint / 1e6) - interval '366 days')sql",
                             us);
    transaction.exec_params0(R"sql(
        DELETE FROM users
         WHERE verified_at IS NULL AND created_at < to_timestamp($1::bigint / 1e6) - interval '7 days')sql",
                             us);
    return {};
  });
}

Result<std::optional<MailStore::Queued>> MailRepository::claim_mail(Time now,
                                                                    std::chrono::seconds lease) {
  return database_.transact([&](pqxx::work& transaction) -> Result<std::optional<Queued>> {
    const pqxx::result claimed = transaction.exec_params(
        R"sql(
        UPDATE mail_queue SET not_before = to_timestamp($2::bigint / 1e6)
         WHERE id = (SELECT id FROM mail_queue WHERE not_before <= to_timestamp($1::bigint / 1e6)
                      ORDER BY not_before, id LIMIT 1 FOR UPDATE SKIP LOCKED)
        RETURNING id, attempts, recipient, subject, body)sql",
        to_us(now), to_us(now + lease));
    if (claimed.empty()) return std::nullopt;
    const pqxx::row row = claimed[0];
    return Queued{row["id"].as<std::int64_t>(),
                  row["attempts"].as<int>(),
                  {row["recipient"].as<std::string>(), row["subject"].as<std::string>(),
                   row["body"].as<std::string>()}};
  });
}

Result<void> MailRepository::mail_sent(std::int64_t id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0("DELETE FROM mail_queue WHERE id = $1", id);
    return {};
  });
}

Result<void> MailRepository::mail_failed(std::int64_t id, Time not_before) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(R"sql(
        UPDATE mail_queue SET attempts = attempts + 1, not_before = to_timestamp($2::bigint / 1e6)
         WHERE id = $1)sql",
                             id, to_us(not_before));
    return {};
  });
}

}  // namespace diaphane::api
