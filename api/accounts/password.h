#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::api {

/// Explains what is wrong with a new password, or returns nothing. A password needs 12 to 200
/// characters and must not be the email address or easy to guess (common_passwords.h). There are no
/// composition rules (NIST SP 800-63B, 5.1.1.2).
std::optional<std::string> fault_of_password(std::string_view password, std::string_view email);

/// Returns whether email can be sent to the address: visible ASCII with one @ and 3 to 254
/// characters (RFC 5321).
bool is_email(std::string_view text);
/// Returns the address in lower case. Two addresses with equal keys belong to the same account.
std::string email_key(std::string_view email);

/// The cost of computing one hash, and therefore of each guess at a password. The default follows
/// the OWASP password storage cheat sheet of 2023.
struct PasswordCost {
  std::uint32_t memory_kib = 19 * 1024;
  std::uint32_t passes = 2;
};

/// Hashes passwords with argon2id and one lane. Computes at most `slots` hashes at the same time
/// while twice as many calls wait, so that a flood of sign-ins exhausts neither the memory nor the
/// threads. Returns kUnavailable if there is no room within `patience`.
class PasswordHasher {
 public:
  explicit PasswordHasher(int slots, std::chrono::milliseconds patience = std::chrono::seconds(2),
                          PasswordCost cost = {});

  /// Returns the encoded hash with a random salt.
  Result<std::string> hash(std::string_view password);
  Result<bool> verify(std::string_view password, const std::string& encoded);
  /// Does the work of verify() and returns false, so that timing does not reveal a missing account.
  Result<bool> verify_dummy(std::string_view password);

 private:
  class Turn;
  bool enter();
  void leave();

  const int slots_;
  const std::chrono::milliseconds patience_;
  const PasswordCost cost_;
  std::mutex mutex_;
  std::condition_variable free_;
  int running_ = 0;
  int waiting_ = 0;
  std::string nothing_;  ///< hash of a random password
};

}  // namespace diaphane::api
