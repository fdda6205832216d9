#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::api {

/// What is wrong with a new password, or nothing. 12 to 200 characters, not the e-mail address, and
/// nothing that is guessed first (common_passwords.h); no rule of composition (NIST SP 800-63B,
/// 5.1.1.2).
std::optional<std::string> fault_of_password(std::string_view password, std::string_view email);

/// The address is one that mail can be sent to: visible ASCII, one @, 3 to 254 characters (RFC
/// 5321).
bool is_email(std::string_view text);
/// The form in which two addresses are the same account's: lower case.
std::string email_key(std::string_view email);

/// argon2id, 19 MiB, 2 passes, 1 lane (OWASP password storage cheat sheet, 2023). At most `slots`
/// are computed at once and as many again wait, so that a flood of sign-ins takes neither the
/// memory nor every thread: kUnavailable when there is no room within `patience`.
class PasswordHasher {
 public:
  explicit PasswordHasher(int slots, std::chrono::milliseconds patience = std::chrono::seconds(2));

  /// The encoded form, with its own random salt.
  Result<std::string> hash(std::string_view password);
  Result<bool> verify(std::string_view password, const std::string& encoded);
  /// The work of a verify, for an account that does not exist, so that time does not tell.
  Result<bool> verify_nothing(std::string_view password);

 private:
  class Turn;
  bool enter();
  void leave();

  const int slots_;
  const std::chrono::milliseconds patience_;
  std::mutex mutex_;
  std::condition_variable free_;
  int running_ = 0;
  int waiting_ = 0;
  std::string nothing_;  ///< the hash of a random password
};

}  // namespace diaphane::api
