#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/accounts/account_store.h"
#include "api/accounts/accounts.h"
#include "api/accounts/code_check.h"
#include "api/shared/signals.h"

namespace diaphane::api {

/// The state of two-factor authentication as shown to the user.
struct SecondFactorState {
  std::optional<Time> set_up_at;  ///< empty if it is off
  int recovery_codes = 0;         ///< number of unused codes
  bool required = false;          ///< whether the user's role requires it
};

/// A new secret whose first code has not been confirmed.
struct NewSecondFactor {
  std::string secret;  ///< in Base32, for manual entry
  std::string uri;     ///< otpauth:// URI for the QR code
};

/// Sets up, renews and removes the second factor of an account (docs/adr/0023). Thread-safe.
class SecondFactors {
 public:
  struct Options {
    /// Time limit for confirming the first code.
    std::chrono::seconds begun_life = std::chrono::hours(1);
  };

  SecondFactors(SecondFactorStore& store, Accounts& accounts, CodeCheck& codes,
                const SealingKey& key, const Clock& clock, const Signals& signals, Options options);

  Outcome<SecondFactorState> state(const Principal& who);
  /// Creates a new secret, which replaces an unconfirmed one. Returns kConflict if two-factor
  /// authentication is on, and an error of the field "password" for a wrong password.
  Outcome<NewSecondFactor> begin(const Principal& who, const std::string& password);
  /// Confirms the first code and turns on two-factor authentication. Ends all other web sessions
  /// and returns the recovery codes, which are shown only once. Returns kConflict if no setup is in
  /// progress or it has expired, and an error of the field "code" for a wrong one.
  Outcome<std::vector<std::string>> confirm(const Principal& who, const std::string& code);
  /// Replaces all recovery codes. The code may be a recovery code. Returns errors of "password" and
  /// "code", kTooManyAttempts, or kConflict if two-factor authentication is off.
  Outcome<std::vector<std::string>> renew_recovery_codes(const Principal& who,
                                                         const std::string& password,
                                                         const std::string& code);
  /// Turns off two-factor authentication. Returns the same errors as renew_recovery_codes.
  Outcome<void> remove(const Principal& who, const std::string& password, const std::string& code);

 private:
  /// Requires password and code again before a change that weakens the account.
  Outcome<void> confirm_both(const Principal& who, const std::string& password,
                             const std::string& code);

  SecondFactorStore& store_;
  Accounts& accounts_;
  CodeCheck& codes_;
  const SealingKey& key_;
  const Clock& clock_;
  const Signals& signals_;
  Options options_;
};

}  // namespace diaphane::api
