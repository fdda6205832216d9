#include "api/shared/idempotency_rows.h"

namespace diaphane::api {

std::optional<std::variant<Created, KeyReused>> made_before(
    pqxx::work& transaction, const std::string& user_id, const std::optional<IdempotencyKey>& key) {
  if (!key) return std::nullopt;
  transaction.exec_params(
      "SELECT pg_advisory_xact_lock(hashtextextended($1 || ' ' || $2 || ' ' || $3, 0))::text",
      user_id, key->route, key->key);
  const pqxx::result before = transaction.exec_params(
      R"sql(
      SELECT request_hash, created_id FROM idempotency_keys
       WHERE user_id = $1 AND route = $2 AND key = $3)sql",
      user_id, key->route, key->key);
  if (before.empty()) return std::nullopt;
  if (before[0]["request_hash"].as<std::string>() != key->request_hash) return KeyReused{};
  return Created{before[0]["created_id"].as<std::string>(), true};
}

void note_made(pqxx::work& transaction, const std::string& user_id,
               const std::optional<IdempotencyKey>& key, const std::string& id, Time now) {
  if (!key) return;
  transaction.exec_params0(
      R"sql(
      INSERT INTO idempotency_keys (user_id, route, key, request_hash, created_id, created_at)
      VALUES ($1, $2, $3, $4, $5, to_timestamp($6::bigint / 1e6)))sql",
      user_id, key->route, key->key, key->request_hash, id, to_us(now));
}

}  // namespace diaphane::api
