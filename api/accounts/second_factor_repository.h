#pragma once

#include "api/accounts/code_check.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// Second factors of accounts and their recovery codes (migrations/0009).
class SecondFactorRepository final : public SecondFactorStore {
 public:
  explicit SecondFactorRepository(Database& database) : database_(database) {}

  Result<std::optional<SecondFactor>> find(const std::string& user_id) override;
  Result<bool> begin(const std::string& user_id, const std::string& sealed_secret,
                     Time now) override;
  Result<bool> confirm(const std::string& user_id, const std::string& sealed_secret,
                       std::int64_t step, const std::vector<std::string>& code_hashes,
                       const std::string& kept_session, const Mail& notification,
                       Time now) override;
  Result<bool> take_step(const std::string& user_id, std::int64_t step) override;
  Result<void> note_reuse(const std::string& user_id, const Mail& notification, Time now) override;
  Result<bool> take_recovery_code(const std::string& user_id, const std::string& code_hash,
                                  const Mail& notification, Time now) override;
  Result<void> renew_recovery_codes(const std::string& user_id,
                                    const std::vector<std::string>& code_hashes,
                                    const Mail& notification, Time now) override;
  Result<void> remove(const std::string& user_id, const Mail& notification, Time now) override;

  /// Removes the second factor for `diaphane-api admin reset-2fa`, for users who lost both their
  /// device and their recovery codes. Returns false if there is no such account or it has no second
  /// factor.
  Result<bool> take_off(const std::string& email_key, const Mail& notification, Time now);

 private:
  Database& database_;
};

}  // namespace diaphane::api
