#include "api/accounts/second_factor_repository.h"

#include "api/accounts/account_repository.h"
#include "api/shared/audit_repository.h"

namespace diaphane::api {
namespace {

void note(pqxx::work& transaction, const std::string& user_id, std::string action, Time now) {
  note_in_audit_log(transaction,
                    {AuditActor::kPerson, user_id, std::move(action), "account", user_id, {}}, now);
}

void put_codes(pqxx::work& transaction, const std::string& user_id,
               const std::vector<std::string>& code_hashes) {
  transaction.exec_params0("DELETE FROM recovery_codes WHERE user_id = $1::uuid", user_id);
  for (const std::string& hash : code_hashes) {
    transaction.exec_params0(
        "INSERT INTO recovery_codes (user_id, code_hash) VALUES ($1::uuid, $2)", user_id, hash);
  }
}

void delete_second_factor(pqxx::work& transaction, const std::string& user_id) {
  transaction.exec_params0("DELETE FROM recovery_codes WHERE user_id = $1::uuid", user_id);
  transaction.exec_params0("DELETE FROM second_factors WHERE user_id = $1::uuid", user_id);
}

}  // namespace

Result<std::optional<SecondFactor>> SecondFactorRepository::find(const std::string& user_id) {
  return database_.read([&](pqxx::work& transaction) -> Result<std::optional<SecondFactor>> {
    const pqxx::result found = transaction.exec_params(
        R"sql(
        SELECT sealed_secret, (extract(epoch FROM begun_at) * 1000000)::bigint AS begun_us,
               (extract(epoch FROM confirmed_at) * 1000000)::bigint AS confirmed_us, last_step,
               (SELECT count(*)::int FROM recovery_codes r WHERE r.user_id = f.user_id) AS recovery_codes
          FROM second_factors f WHERE user_id = $1::uuid)sql",
        user_id);
    if (found.empty()) return std::nullopt;
    const pqxx::row row = found[0];
    SecondFactor factor{row["sealed_secret"].as<std::string>(),
                        from_us(row["begun_us"].as<std::int64_t>()), std::nullopt,
                        row["last_step"].as<std::int64_t>(), row["recovery_codes"].as<int>()};
    if (!row["confirmed_us"].is_null())
      factor.confirmed_at = from_us(row["confirmed_us"].as<std::int64_t>());
    return factor;
  });
}

Result<bool> SecondFactorRepository::begin(const std::string& user_id,
                                           const std::string& sealed_secret, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result made = transaction.exec_params(
        R"sql(
        INSERT INTO second_factors AS f (user_id, sealed_secret, begun_at)
        VALUES ($1::uuid, $2, to_timestamp($3::bigint / 1e6))
        ON CONFLICT (user_id) DO UPDATE
           SET sealed_secret = excluded.sealed_secret, begun_at = excluded.begun_at, last_step = 0
         WHERE f.confirmed_at IS NULL)sql",
        user_id, sealed_secret, to_us(now));
    return made.affected_rows() > 0;
  });
}

Result<bool> SecondFactorRepository::confirm(const std::string& user_id,
                                             const std::string& sealed_secret, std::int64_t step,
                                             const std::vector<std::string>& code_hashes,
                                             const std::string& kept_session,
                                             const Mail& notification, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result confirmed = transaction.exec_params(
        R"sql(
        UPDATE second_factors SET confirmed_at = to_timestamp($4::bigint / 1e6), last_step = $3
         WHERE user_id = $1::uuid AND sealed_secret = $2 AND confirmed_at IS NULL)sql",
        user_id, sealed_secret, step, to_us(now));
    if (confirmed.affected_rows() == 0) return false;
    put_codes(transaction, user_id, code_hashes);
    expire_sessions(transaction, user_id, kept_session);
    queue_mail(transaction, notification, now);
    note(transaction, user_id, "account.second-factor-added", now);
    return true;
  });
}

Result<bool> SecondFactorRepository::take_step(const std::string& user_id, std::int64_t step) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result taken = transaction.exec_params(
        "UPDATE second_factors SET last_step = $2 WHERE user_id = $1::uuid AND last_step < $2",
        user_id, step);
    return taken.affected_rows() > 0;
  });
}

Result<void> SecondFactorRepository::note_reuse(const std::string& user_id,
                                                const Mail& notification, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    queue_mail(transaction, notification, now);
    note(transaction, user_id, "account.code-reused", now);
    return {};
  });
}

Result<bool> SecondFactorRepository::take_recovery_code(const std::string& user_id,
                                                        const std::string& code_hash,
                                                        const Mail& notification, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result taken = transaction.exec_params(
        "DELETE FROM recovery_codes WHERE user_id = $1::uuid AND code_hash = $2", user_id,
        code_hash);
    if (taken.affected_rows() == 0) return false;
    queue_mail(transaction, notification, now);
    note(transaction, user_id, "account.recovery-code-used", now);
    return true;
  });
}

Result<void> SecondFactorRepository::renew_recovery_codes(
    const std::string& user_id, const std::vector<std::string>& code_hashes,
    const Mail& notification, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    put_codes(transaction, user_id, code_hashes);
    queue_mail(transaction, notification, now);
    note(transaction, user_id, "account.recovery-codes-renewed", now);
    return {};
  });
}

Result<void> SecondFactorRepository::remove(const std::string& user_id, const Mail& notification,
                                            Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    delete_second_factor(transaction, user_id);
    queue_mail(transaction, notification, now);
    note(transaction, user_id, "account.second-factor-removed", now);
    return {};
  });
}

Result<bool> SecondFactorRepository::take_off(const std::string& email_key,
                                              const Mail& notification, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result found = transaction.exec_params(
        R"sql(
        SELECT u.id FROM users u JOIN second_factors f ON f.user_id = u.id
         WHERE u.email_key = $1 AND f.confirmed_at IS NOT NULL)sql",
        email_key);
    if (found.empty()) return false;
    const auto user_id = found[0]["id"].as<std::string>();
    delete_second_factor(transaction, user_id);
    queue_mail(transaction, notification, now);
    note_in_audit_log(
        transaction,
        {AuditActor::kMachine, "", "account.second-factor-removed", "account", user_id, {}}, now);
    return true;
  });
}

}  // namespace diaphane::api
