#pragma once

#include "api/accounts/api_tokens.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// API tokens of accounts (migrations/0026).
class ApiTokenRepository final : public ApiTokenStore {
 public:
  explicit ApiTokenRepository(Database& database) : database_(database) {}

  Result<bool> create(const std::string& user_id, const std::string& session_id,
                      const ApiToken& token, const std::string& token_hash, int most,
                      const Mail& notification) override;
  Result<std::vector<ApiToken>> list(const std::string& user_id, Time now) override;
  Result<bool> revoke(const std::string& user_id, const std::string& id, Time now) override;
  Result<std::optional<TokenUse>> find(const std::string& token_hash, Time now) override;
  Result<void> touch(const std::string& id, Time used_at) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
