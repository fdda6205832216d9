#pragma once

#include <functional>
#include <string>
#include <vector>

#include "api/service/accounts.h"
#include "api/service/placement.h"

namespace diaphane::api {

class AccountDeletionStore {
 public:
  virtual ~AccountDeletionStore() = default;
  /// All rows of the account go, its files are noted for disposal, its id is blanked in the audit
  /// log; a last mail is queued. The ids of its data sets. One transaction. kUnavailable.
  virtual Result<std::vector<std::string>> remove_account(
      const std::string& user_id, const std::string& email,
      const std::vector<std::string>& attempt_keys, const Mail& told, Time now) = 0;
};

/// The end of an account: at once, and of everything. Thread-safe.
class AccountDeletion {
 public:
  AccountDeletion(AccountDeletionStore& store, Accounts& accounts, Placement& placement,
                  const Clock& clock)
      : store_(store), accounts_(accounts), placement_(placement), clock_(clock) {}

  /// Confirmed by the password, as Accounts::confirm_password.
  Outcome<void> remove(const Principal& who, const std::string& password);
  /// Called after files were noted for disposal, and a mail queued.
  void on_removal(std::function<void()> wake) { wake_ = std::move(wake); }

 private:
  AccountDeletionStore& store_;
  Accounts& accounts_;
  Placement& placement_;
  const Clock& clock_;
  std::function<void()> wake_ = [] {};
};

}  // namespace diaphane::api
