#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/accounts/account_store.h"
#include "api/accounts/language.h"
#include "api/shared/problem.h"
#include "api/shared/secrets.h"
#include "api/shared/signals.h"
#include "common/clock.h"

namespace diaphane::api {

/// The stored second factor of an account.
struct SecondFactor {
  std::string sealed_secret;  ///< encrypted with SealingKey for the account's ID
  Time begun_at;
  std::optional<Time> confirmed_at;  ///< empty while it has no effect yet
  std::int64_t last_step = 0;        ///< totp::step_of of the newest accepted code
  int recovery_codes = 0;
};

/// Every function returns kUnavailable if the database is unavailable. Each is one transaction,
/// which includes its entry in the audit log.
class SecondFactorStore {
 public:
  virtual ~SecondFactorStore() = default;
  virtual Result<std::optional<SecondFactor>> find(const std::string& user_id) = 0;
  /// Replaces an unconfirmed second factor. Returns false if there is a confirmed one.
  virtual Result<bool> begin(const std::string& user_id, const std::string& sealed_secret,
                             Time now) = 0;
  /// Turns on two-factor authentication and ends all web sessions except `kept_session`. Returns
  /// false if the secret no longer exists or has already been confirmed.
  virtual Result<bool> confirm(const std::string& user_id, const std::string& sealed_secret,
                               std::int64_t step, const std::vector<std::string>& code_hashes,
                               const std::string& kept_session, const Mail& notification,
                               Time now) = 0;
  /// Records an accepted code. Returns false if one of this or a later step was already accepted.
  virtual Result<bool> take_step(const std::string& user_id, std::int64_t step) = 0;
  /// Records that a code was entered again while it was still valid.
  virtual Result<void> note_reuse(const std::string& user_id, const Mail& notification,
                                  Time now) = 0;
  /// Consumes a recovery code. Returns false if there is no code with this hash.
  virtual Result<bool> take_recovery_code(const std::string& user_id, const std::string& code_hash,
                                          const Mail& notification, Time now) = 0;
  virtual Result<void> renew_recovery_codes(const std::string& user_id,
                                            const std::vector<std::string>& code_hashes,
                                            const Mail& notification, Time now) = 0;
  virtual Result<void> remove(const std::string& user_id, const Mail& notification, Time now) = 0;
};

/// Returns the stored form of a recovery code: blake2b of the code in lower case without spaces and
/// dashes, with 0, 1 and 8 replaced by the letters they resemble. Returns nothing if malformed.
std::optional<std::string> recovery_code_hash(std::string_view typed);
/// Returns ten codes of 120 random bits in readable form, "abcd-efgh-ijkl-mnop-qrst-uvwx".
std::vector<std::string> new_recovery_codes();

/// Verifies the second factor of an account: a current TOTP code or a recovery code. Each code is
/// accepted only once. Thread-safe.
class CodeCheck {
 public:
  struct Options {
    std::string public_url;  ///< origin of links in emails
    std::chrono::seconds window = std::chrono::minutes(15);
    int failures = 5;         ///< in `window`
    int failures_a_day = 20;  ///< of a million codes, three are valid at a time
  };

  CodeCheck(SecondFactorStore& store, AccountStore& attempts, const SealingKey& key,
            const Clock& clock, const Signals& signals, Options options);

  /// Returns whether signing in requires a code.
  Outcome<bool> needed(const std::string& user_id);
  /// Returns whether `code` is correct, and consumes a correct one. Returns kTooManyAttempts after
  /// too many failures, even for a correct code. Notifies `email` in `language` if a recovery code
  /// was used or a code was reused.
  Outcome<bool> take(const std::string& user_id, const std::string& email, const std::string& code,
                     Language language);

  std::string account_url() const { return options_.public_url + "/account"; }

 private:
  /// Returns false for a reused code, and logs and reports the reuse.
  Outcome<bool> was_used(const std::string& user_id, const std::string& email, Language language,
                         Time now);
  Outcome<bool> is_right(const std::string& user_id, const std::string& email,
                         const std::string& code, Language language, Time now);

  SecondFactorStore& store_;
  AccountStore& attempts_;
  const SealingKey& key_;
  const Clock& clock_;
  const Signals& signals_;
  Options options_;
};

}  // namespace diaphane::api
