#pragma once

#include "api/accounts/account_changes.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// Passwords, addresses and browsers of accounts (migrations/0001, 0004).
class AccountChangeRepository final : public AccountChangeStore {
 public:
  explicit AccountChangeRepository(Database& database) : database_(database) {}

  Result<void> request_reset(const std::string& email_key, const std::string& token_hash,
                             Time expires_at, const ResetMails& mails) override;
  Result<std::optional<TokenBearer>> find_token(const std::string& token_hash,
                                                const std::string& purpose, Time now) override;
  Result<bool> reset(const std::string& token_hash, const std::string& password_hash,
                     const Mail& notification, Time now) override;
  Result<void> change_password(const std::string& user_id, const std::string& password_hash,
                               const std::string& kept_session, const Mail& notification,
                               Time now) override;
  Result<void> request_email(const EmailRequest& request, Time now) override;
  Result<bool> confirm_email(const std::string& token_hash, const std::string& new_email_key,
                             const Mail& to_old, Time now) override;
  Result<std::vector<BrowserSession>> browser_sessions(const std::string& user_id,
                                                       Time now) override;
  Result<bool> end_browser_session(const std::string& user_id, const std::string& id) override;
  Result<void> end_browser_sessions(const std::string& user_id, Time now) override;
  Result<std::vector<ExpiredBrowser>> expired_browsers(Time now, int limit) override;
  Result<void> forget_browser(const std::string& id) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
