#include "api/accounts/account_change_repository.h"

#include "api/accounts/account_repository.h"
#include "api/shared/audit_repository.h"

namespace diaphane::api {
namespace {

AuditEntry of_account(const std::string& user_id, std::string action) {
  return {AuditActor::kPerson, user_id, std::move(action), "account", user_id, {}};
}

/// Consumes a token and returns its account, or nothing if it does not exist or has expired.
std::optional<std::string> use_up(pqxx::work& transaction, const std::string& token_hash,
                                  const char* purpose, Time now) {
  const pqxx::result used = transaction.exec_params(R"sql(
      DELETE FROM email_tokens
       WHERE token_hash = $1 AND purpose = $2 AND expires_at > to_timestamp($3::bigint / 1e6)
      RETURNING user_id)sql",
                                                    token_hash, std::string(purpose), to_us(now));
  if (used.empty()) return std::nullopt;
  return used[0]["user_id"].as<std::string>();
}

void set_password(pqxx::work& transaction, const std::string& user_id,
                  const std::string& password_hash) {
  transaction.exec_params0("UPDATE users SET password_hash = $2 WHERE id = $1::uuid", user_id,
                           password_hash);
  // Invalidates earlier links.
  transaction.exec_params0("DELETE FROM email_tokens WHERE user_id = $1::uuid", user_id);
}

}  // namespace

Result<void> AccountChangeRepository::request_reset(const std::string& email_key,
                                                    const std::string& token_hash, Time expires_at,
                                                    const ResetMails& mails) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(
        R"sql(
        WITH known AS (
          SELECT id, disabled_at IS NOT NULL AS is_disabled FROM users
           WHERE email_key = $1 AND verified_at IS NOT NULL),
        person AS (SELECT id FROM known WHERE NOT is_disabled),
        forgotten AS (
          DELETE FROM email_tokens USING person
           WHERE email_tokens.user_id = person.id AND purpose = 'reset'),
        token AS (
          INSERT INTO email_tokens (token_hash, user_id, purpose, expires_at)
          SELECT $2, id, 'reset', to_timestamp($3::bigint / 1e6) FROM person)
        INSERT INTO mail_queue (recipient, subject, body, not_before)
        SELECT $4, CASE is_disabled WHEN false THEN $5 WHEN true THEN $7 ELSE $9 END,
               CASE is_disabled WHEN false THEN $6 WHEN true THEN $8 ELSE $10 END, to_timestamp(0)
          FROM (SELECT (SELECT is_disabled FROM known) AS is_disabled) AS looked_up)sql",
        email_key, token_hash, to_us(expires_at), mails.reset.recipient, mails.reset.subject,
        mails.reset.body, mails.disabled.subject, mails.disabled.body, mails.unknown.subject,
        mails.unknown.body);
    return {};
  });
}

Result<std::optional<TokenBearer>> AccountChangeRepository::find_token(
    const std::string& token_hash, const std::string& purpose, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::optional<TokenBearer>> {
    const pqxx::result found = transaction.exec_params(
        R"sql(
        SELECT u.id, u.email, COALESCE(t.new_email, '') AS new_email
          FROM email_tokens t JOIN users u ON u.id = t.user_id
         WHERE t.token_hash = $1 AND t.purpose = $2 AND u.disabled_at IS NULL
           AND t.expires_at > to_timestamp($3::bigint / 1e6))sql",
        token_hash, purpose, to_us(now));
    if (found.empty()) return std::nullopt;
    return TokenBearer{found[0]["id"].as<std::string>(), found[0]["email"].as<std::string>(),
                       found[0]["new_email"].as<std::string>()};
  });
}

Result<bool> AccountChangeRepository::reset(const std::string& token_hash,
                                            const std::string& password_hash,
                                            const Mail& notification, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const auto user = use_up(transaction, token_hash, "reset", now);
    if (!user) return false;
    set_password(transaction, *user, password_hash);
    expire_sessions(transaction, *user);
    queue_mail(transaction, notification, now);
    note_in_audit_log(transaction, of_account(*user, "account.password-reset"), now);
    return true;
  });
}

Result<void> AccountChangeRepository::change_password(const std::string& user_id,
                                                      const std::string& password_hash,
                                                      const std::string& kept_session,
                                                      const Mail& notification, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    set_password(transaction, user_id, password_hash);
    expire_sessions(transaction, user_id, kept_session);
    queue_mail(transaction, notification, now);
    note_in_audit_log(transaction, of_account(user_id, "account.password-changed"), now);
    return {};
  });
}

Result<void> AccountChangeRepository::request_email(const EmailRequest& request, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    queue_mail(transaction, request.to_old, now);
    note_in_audit_log(transaction, of_account(request.user_id, "account.email-change-asked"), now);
    transaction.exec_params0(
        "DELETE FROM email_tokens WHERE user_id = $1::uuid AND purpose = 'change'",
        request.user_id);
    const pqxx::result taken = transaction.exec_params(
        "SELECT FROM users WHERE email_key = $1 AND verified_at IS NOT NULL",
        request.new_email_key);
    if (!taken.empty()) {
      queue_mail(transaction, request.taken, now);
      return {};
    }
    transaction.exec_params0(R"sql(
        INSERT INTO email_tokens (token_hash, user_id, purpose, expires_at, new_email)
        VALUES ($1, $2::uuid, 'change', to_timestamp($3::bigint / 1e6), $4))sql",
                             request.token_hash, request.user_id, to_us(request.token_expires_at),
                             request.new_email);
    queue_mail(transaction, request.confirm, now);
    return {};
  });
}

Result<bool> AccountChangeRepository::confirm_email(const std::string& token_hash,
                                                    const std::string& new_email_key,
                                                    const Mail& to_old, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result token = transaction.exec_params(
        "SELECT new_email FROM email_tokens WHERE token_hash = $1 AND purpose = 'change' FOR "
        "UPDATE",
        token_hash);
    const auto user = use_up(transaction, token_hash, "change", now);
    if (token.empty() || !user) return false;
    // Removes an account that signed up with this address but never confirmed it.
    transaction.exec_params0("DELETE FROM users WHERE email_key = $1 AND verified_at IS NULL",
                             new_email_key);
    const pqxx::result changed = transaction.exec_params(
        R"sql(
        UPDATE users SET email = $2, email_key = $3
         WHERE id = $1::uuid AND NOT EXISTS (SELECT FROM users WHERE email_key = $3)
        RETURNING id)sql",
        *user, token[0]["new_email"].as<std::string>(), new_email_key);
    if (changed.empty()) return false;
    queue_mail(transaction, to_old, now);
    note_in_audit_log(transaction, of_account(*user, "account.email-changed"), now);
    return true;
  });
}

Result<std::vector<BrowserSession>> AccountChangeRepository::browser_sessions(
    const std::string& user_id, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<BrowserSession>> {
    std::vector<BrowserSession> sessions;
    for (const pqxx::row& row : transaction.exec_params(R"sql(
             SELECT id, browser, (extract(epoch FROM created_at) * 1000000)::bigint AS created_us,
                    (extract(epoch FROM used_at) * 1000000)::bigint AS used_us
               FROM web_sessions
              WHERE user_id = $1::uuid AND expires_at > to_timestamp($2::bigint / 1e6)
              ORDER BY used_at DESC, created_at DESC LIMIT 100)sql",
                                                        user_id, to_us(now))) {
      sessions.push_back({row["id"].as<std::string>(), row["browser"].as<std::string>(),
                          from_us(row["created_us"].as<std::int64_t>()),
                          from_us(row["used_us"].as<std::int64_t>())});
    }
    return sessions;
  });
}

Result<bool> AccountChangeRepository::end_browser_session(const std::string& user_id,
                                                          const std::string& id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result ended = transaction.exec_params(R"sql(
        UPDATE web_sessions SET expires_at = 'epoch'
         WHERE user_id = $1::uuid AND id = $2::uuid AND expires_at > 'epoch')sql",
                                                       user_id, id);
    return ended.affected_rows() > 0;
  });
}

Result<void> AccountChangeRepository::end_browser_sessions(const std::string& user_id, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    expire_sessions(transaction, user_id);
    note_in_audit_log(transaction, of_account(user_id, "account.signed-out-everywhere"), now);
    return {};
  });
}

Result<std::vector<ExpiredBrowser>> AccountChangeRepository::expired_browsers(Time now, int limit) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<ExpiredBrowser>> {
    std::vector<ExpiredBrowser> expired;
    for (const pqxx::row& row : transaction.exec_params(R"sql(
             SELECT id, user_id FROM (
               SELECT id, user_id, expires_at FROM web_sessions
                UNION ALL SELECT id, user_id, expires_at FROM api_tokens) AS access
              WHERE expires_at <= to_timestamp($1::bigint / 1e6) ORDER BY expires_at LIMIT $2)sql",
                                                        to_us(now), limit)) {
      expired.push_back({row["id"].as<std::string>(), row["user_id"].as<std::string>()});
    }
    return expired;
  });
}

Result<void> AccountChangeRepository::forget_browser(const std::string& id) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0("DELETE FROM web_sessions WHERE id = $1::uuid", id);
    transaction.exec_params0("DELETE FROM api_tokens WHERE id = $1::uuid", id);
    return {};
  });
}

}  // namespace diaphane::api
