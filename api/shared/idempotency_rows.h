#pragma once

#include <optional>
#include <variant>

#include "api/shared/database.h"
#include "api/shared/idempotency.h"

namespace diaphane::api {

/// Returns what this user's key has created before, if anything. Call it first in the transaction
/// that creates the resource. A concurrent request with the same key waits for this transaction.
std::optional<std::variant<Created, KeyReused>> made_before(
    pqxx::work& transaction, const std::string& user_id, const std::optional<IdempotencyKey>& key);

/// Records in the transaction of the creation that the key, if any, created the resource `id`.
void note_made(pqxx::work& transaction, const std::string& user_id,
               const std::optional<IdempotencyKey>& key, const std::string& id, Time now);

}  // namespace diaphane::api
