#pragma once

#include <optional>
#include <variant>

#include "api/postgres/database.h"
#include "api/service/idempotency.h"

namespace diaphane::api {

/// What this person's key has made before, if anything; asked first in the transaction that would
/// make it. The same key beside this one waits until this transaction has ended.
std::optional<std::variant<Created, KeyReused>> made_before(
    pqxx::work& transaction, const std::string& user_id, const std::optional<IdempotencyKey>& key);

/// In that same transaction, once it is made. Without a key nothing is noted.
void note_made(pqxx::work& transaction, const std::string& user_id,
               const std::optional<IdempotencyKey>& key, const std::string& id, Time now);

}  // namespace diaphane::api
