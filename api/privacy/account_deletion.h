#pragma once

#include <string>
#include <vector>

#include "api/accounts/accounts.h"
#include "api/shared/placement.h"
#include "api/shared/signals.h"

namespace diaphane::api {

/// Deletes accounts from the database.
class AccountDeletionStore {
 public:
  virtual ~AccountDeletionStore() = default;
  /// In one transaction, deletes all rows of the account, queues its files for deletion, removes
  /// its ID from the audit log and queues a last email. Returns the IDs of its data sets, or
  /// kUnavailable.
  virtual Result<std::vector<std::string>> remove_account(
      const std::string& user_id, const std::string& email,
      const std::vector<std::string>& attempt_keys, const Mail& notification, Time now) = 0;
};

/// Deletes an account and all its data immediately. Thread-safe.
class AccountDeletion {
 public:
  AccountDeletion(AccountDeletionStore& store, Accounts& accounts, Placement& placement,
                  const Clock& clock, const Signals& signals)
      : store_(store),
        accounts_(accounts),
        placement_(placement),
        clock_(clock),
        signals_(signals) {}

  /// Requires the password and, with two-factor authentication, the code. Returns the errors of
  /// Accounts::confirm_password and confirm_code.
  Outcome<void> remove(const Principal& who, const std::string& password, const std::string& code);

 private:
  AccountDeletionStore& store_;
  Accounts& accounts_;
  Placement& placement_;
  const Clock& clock_;
  const Signals& signals_;
};

}  // namespace diaphane::api
