#include "api/accounts/api_token_repository.h"

#include <algorithm>

#include "api/accounts/account_repository.h"
#include "api/shared/audit_repository.h"

namespace diaphane::api {
namespace {

constexpr const char* kColumns =
    "t.id, t.name, t.scopes, (extract(epoch FROM t.created_at) * 1000000)::bigint AS created_us, "
    "(extract(epoch FROM t.expires_at) * 1000000)::bigint AS expires_us, "
    "(extract(epoch FROM t.used_at) * 1000000)::bigint AS used_us ";

ApiToken read_token(const pqxx::row& row) {
  ApiToken token{row["id"].as<std::string>(),
                 row["name"].as<std::string>(),
                 split_scopes(row["scopes"].as<std::string>()),
                 from_us(row["created_us"].as<std::int64_t>()),
                 from_us(row["expires_us"].as<std::int64_t>()),
                 {}};
  if (!row["used_us"].is_null()) token.used_at = from_us(row["used_us"].as<std::int64_t>());
  return token;
}

AuditEntry entry(const std::string& user_id, std::string action, const std::string& token_id,
                 std::vector<AuditDetail> details = {}) {
  details.emplace_back("token", token_id);
  return {AuditActor::kPerson, user_id, std::move(action), "account", user_id, std::move(details)};
}

}  // namespace

Result<bool> ApiTokenRepository::create(const std::string& user_id, const std::string& session_id,
                                        const ApiToken& token, const std::string& token_hash,
                                        int most, const Mail& notification) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    // Locks the account, so that concurrent requests cannot exceed the limit together.
    transaction.exec_params("SELECT FROM users WHERE id = $1::uuid FOR UPDATE", user_id);
    // A password that was changed since it was checked has ended the session under the same lock.
    const pqxx::result session = transaction.exec_params(
        R"sql(
        SELECT FROM web_sessions
         WHERE id = $1::uuid AND user_id = $2::uuid AND expires_at > to_timestamp($3::bigint / 1e6))sql",
        session_id, user_id, to_us(token.created_at));
    if (session.empty()) return fail(ErrorCode::kNotFound, "The session has ended.");
    const pqxx::result made = transaction.exec_params(
        R"sql(
        INSERT INTO api_tokens (id, user_id, token_hash, name, scopes, created_at, expires_at)
        SELECT $1::uuid, $2::uuid, $3, $4, $5, to_timestamp($6::bigint / 1e6), to_timestamp($7::bigint / 1e6)
         WHERE (SELECT count(*) FROM api_tokens
                 WHERE user_id = $2::uuid AND NOT for_fetch AND expires_at > to_timestamp($6::bigint / 1e6)) < $8)sql",
        token.id, user_id, token_hash, token.name, join_scopes(token.scopes),
        to_us(token.created_at), to_us(token.expires_at), most);
    if (made.affected_rows() == 0) return false;
    queue_mail(transaction, notification, token.created_at);
    // Text details of the audit log are code words, which cannot contain spaces.
    std::string scopes = join_scopes(token.scopes);
    std::replace(scopes.begin(), scopes.end(), ' ', '.');
    note_in_audit_log(transaction,
                      entry(user_id, "account.token-created", token.id, {{"scopes", scopes}}),
                      token.created_at);
    return true;
  });
}

Result<std::vector<ApiToken>> ApiTokenRepository::list(const std::string& user_id, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::vector<ApiToken>> {
    std::vector<ApiToken> tokens;
    for (const pqxx::row& row :
         transaction.exec_params(std::string("SELECT ") + kColumns +
                                     "FROM api_tokens t WHERE user_id = $1::uuid "
                                     "AND NOT for_fetch AND expires_at > to_timestamp($2::bigint / "
                                     "1e6) ORDER BY created_at DESC, id",
                                 user_id, to_us(now))) {
      tokens.push_back(read_token(row));
    }
    return tokens;
  });
}

Result<bool> ApiTokenRepository::revoke(const std::string& user_id, const std::string& id,
                                        Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result ended = transaction.exec_params(
        R"sql(
        UPDATE api_tokens SET expires_at = 'epoch'
         WHERE user_id = $1::uuid AND id = $2::uuid
           AND expires_at > to_timestamp($3::bigint / 1e6))sql",
        user_id, id, to_us(now));
    if (ended.affected_rows() == 0) return false;
    note_in_audit_log(transaction, entry(user_id, "account.token-revoked", id), now);
    return true;
  });
}

Result<std::optional<TokenUse>> ApiTokenRepository::find(const std::string& token_hash, Time now) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::optional<TokenUse>> {
    const pqxx::result found = transaction.exec_params(
        std::string("SELECT u.id AS user_id, u.email, "
                    "coalesce(u.consent_version, '') AS consent_version, u.archive_access, "
                    "t.for_fetch, ") +
            kColumns +
            "FROM api_tokens t JOIN users u ON u.id = t.user_id WHERE t.token_hash = $1 "
            "AND t.expires_at > to_timestamp($2::bigint / 1e6) AND u.disabled_at IS NULL",
        token_hash, to_us(now));
    if (found.empty()) return std::nullopt;
    return TokenUse{read_token(found[0]),
                    found[0]["user_id"].as<std::string>(),
                    found[0]["email"].as<std::string>(),
                    found[0]["consent_version"].as<std::string>(),
                    found[0]["archive_access"].as<bool>(),
                    found[0]["for_fetch"].as<bool>()};
  });
}

Result<void> ApiTokenRepository::touch(const std::string& id, Time used_at) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    transaction.exec_params0(
        "UPDATE api_tokens SET used_at = to_timestamp($2::bigint / 1e6) WHERE id = $1::uuid", id,
        to_us(used_at));
    return {};
  });
}

}  // namespace diaphane::api
