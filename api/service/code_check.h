#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/service/account_store.h"
#include "api/service/problem.h"
#include "api/service/secrets.h"
#include "common/clock.h"

namespace diaphane::api {

/// The second factor of an account, as it is kept.
struct SecondFactor {
  std::string sealed_secret;  ///< SealingKey, for the account's id
  Time begun_at;
  std::optional<Time> confirmed_at;  ///< nothing: it counts for nothing yet
  std::int64_t last_step = 0;        ///< totp::step_of of the newest code that was taken
  int recovery_codes = 0;
};

/// Every function: kUnavailable when the database is away. Each is one transaction, its entry in
/// the audit log included.
class SecondFactorStore {
 public:
  virtual ~SecondFactorStore() = default;
  virtual Result<std::optional<SecondFactor>> find(const std::string& user_id) = 0;
  /// In place of one that was not confirmed. False: there is one that was.
  virtual Result<bool> begin(const std::string& user_id, const std::string& sealed_secret,
                             Time now) = 0;
  /// Ends every browser's session but `kept_session`. False: that secret has gone meanwhile, or was
  /// confirmed.
  virtual Result<bool> confirm(const std::string& user_id, const std::string& sealed_secret,
                               std::int64_t step, const std::vector<std::string>& code_hashes,
                               const std::string& kept_session, const Mail& told, Time now) = 0;
  /// False: a code of this step or a later one was taken meanwhile.
  virtual Result<bool> take_step(const std::string& user_id, std::int64_t step) = 0;
  /// That a code was given once more while it would still have been right.
  virtual Result<void> note_reuse(const std::string& user_id, const Mail& told, Time now) = 0;
  /// False: there is none of that hash (any more).
  virtual Result<bool> take_recovery_code(const std::string& user_id, const std::string& code_hash,
                                          const Mail& told, Time now) = 0;
  virtual Result<void> renew_recovery_codes(const std::string& user_id,
                                            const std::vector<std::string>& code_hashes,
                                            const Mail& told, Time now) = 0;
  virtual Result<void> remove(const std::string& user_id, const Mail& told, Time now) = 0;
};

/// A recovery code as it is stored: blake2b of it without blanks and dashes, in lower case, with
/// 0, 1 and 8 read as the letters that they are mistaken for. Nothing: it has no code's form.
std::optional<std::string> recovery_code_hash(std::string_view typed);
/// Ten of them as a person reads them, "abcd-efgh-ijkl-mnop-qrst-uvwx": 120 random bits.
std::vector<std::string> new_recovery_codes();

/// Whether somebody has the second factor of an account: a code of the moment, or a recovery code.
/// Each is taken once. Thread-safe.
class CodeCheck {
 public:
  struct Options {
    std::string public_url;  ///< origin, for links in mails
    std::chrono::seconds window = std::chrono::minutes(15);
    int failures = 5;         ///< in `window`
    int failures_a_day = 20;  ///< of a million codes, three of which are right at a time
  };

  CodeCheck(SecondFactorStore& store, AccountStore& attempts, const SealingKey& key,
            const Clock& clock, Options options);

  /// Whether signing in needs a code.
  Outcome<bool> needed(const std::string& user_id);
  /// Whether `code` is right; a right one is used up. kTooManyAttempts, also for a right one.
  /// `email` is told when it was a recovery code, and when a code was given a second time.
  Outcome<bool> take(const std::string& user_id, const std::string& email, const std::string& code);

  std::string account_url() const { return options_.public_url + "/account"; }
  void on_mail(std::function<void()> wake) { wake_mailer_ = std::move(wake); }

 private:
  /// False, told and noted: what was given a second time.
  Outcome<bool> was_used(const std::string& user_id, const std::string& email, Time now);
  Outcome<bool> is_right(const std::string& user_id, const std::string& email,
                         const std::string& code, Time now);

  SecondFactorStore& store_;
  AccountStore& attempts_;
  const SealingKey& key_;
  const Clock& clock_;
  Options options_;
  std::function<void()> wake_mailer_ = [] {};
};

}  // namespace diaphane::api
