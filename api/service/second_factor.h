#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/service/account_store.h"
#include "api/service/accounts.h"
#include "api/service/code_check.h"

namespace diaphane::api {

/// What a person sees of the own second factor.
struct SecondFactorState {
  std::optional<Time> set_up_at;  ///< nothing: there is none
  int recovery_codes = 0;         ///< that were not used yet
  bool required = false;          ///< for what the person's role allows
};

/// A secret that was made just now, before a code of it was given.
struct NewSecondFactor {
  std::string secret;  ///< in base 32, for who types it
  std::string uri;     ///< otpauth://, for who scans it
};

/// Setting up, renewing and removing the second factor of an account (docs/adr/0023). Thread-safe.
class SecondFactors {
 public:
  struct Options {
    std::chrono::seconds begun_life = std::chrono::hours(1);  ///< to give the first code within
  };

  SecondFactors(SecondFactorStore& store, Accounts& accounts, CodeCheck& codes,
                const SealingKey& key, const Clock& clock, Options options);

  Outcome<SecondFactorState> state(const Principal& who);
  /// A new secret, in place of one that was begun and not confirmed. kConflict: there is one
  /// already. A wrong password is a fault of "password".
  Outcome<NewSecondFactor> begin(const Principal& who, const std::string& password);
  /// The first code: from now on signing in asks for one. Ends every other browser's session, and
  /// gives the recovery codes, which are shown this once. kConflict: none was begun, or too long
  /// ago. A wrong code is a fault of "code".
  Outcome<std::vector<std::string>> confirm(const Principal& who, const std::string& code);
  /// New recovery codes in place of all old ones. Faults of "password" and "code", which may be a
  /// recovery code; kTooManyAttempts; kConflict: there is no second factor.
  Outcome<std::vector<std::string>> renew_recovery_codes(const Principal& who,
                                                         const std::string& password,
                                                         const std::string& code);
  /// Refuses as renew_recovery_codes does.
  Outcome<void> remove(const Principal& who, const std::string& password, const std::string& code);

  void on_mail(std::function<void()> wake) { wake_mailer_ = std::move(wake); }
  /// Called after other browsers were signed out: their streams are to be ended.
  void on_sign_out(std::function<void()> call) { signed_out_ = std::move(call); }

 private:
  /// Password and code once more, before what weakens the account.
  Outcome<void> confirm_both(const Principal& who, const std::string& password,
                             const std::string& code);

  SecondFactorStore& store_;
  Accounts& accounts_;
  CodeCheck& codes_;
  const SealingKey& key_;
  const Clock& clock_;
  Options options_;
  std::function<void()> wake_mailer_ = [] {};
  std::function<void()> signed_out_ = [] {};
};

}  // namespace diaphane::api
