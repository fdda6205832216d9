#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/shared/time.h"
#include "common/result.h"

namespace diaphane::api {

struct Mail {
  std::string recipient;
  std::string subject;
  std::string body;  ///< plain text in UTF-8 with \n line ends
};

struct SignUp {
  std::string user_id;
  std::string email;
  std::string email_key;
  std::string token_hash;  ///< blake2b of the token (secrets.h)
  Time token_expires_at;
  std::string consent_version;  ///< version of the privacy notice that the user agreed to
  Mail welcome;                 ///< with the link
  Mail already_there;           ///< for an address that already has a verified account
};

struct Account {
  std::string id;
  std::string email;
  std::string password_hash;  ///< empty until the address is confirmed
  bool verified = false;
  bool disabled = false;
};

struct WebSession {
  std::string token_hash;
  std::string user_id;
  std::string csrf_token;
  Time created_at;
  Time expires_at;
  std::string id = {};       ///< public ID, shown to its user
  std::string browser = {};  ///< approximate name, for example "Firefox on Windows"
};

struct SignedIn {
  WebSession session;
  std::string email;
  bool administrator = false;
  Time used_at = {};
  bool second_factor = false;        ///< whether two-factor authentication is on
  std::string consent_version = {};  ///< of the privacy notice; empty without consent
  bool researcher = false;
  bool archive_access = false;
};

struct Quota {
  std::int64_t bytes = 0;
  std::int64_t used = 0;
};

/// Allows at most `count` attempts for `key` within `window`.
struct AttemptLimit {
  std::string key_hash;  ///< blake2b of what is counted (attempts.h)
  int count = 0;
  std::chrono::seconds window{0};
};

/// Stores accounts. Every function returns kUnavailable if the database is unavailable. Each is one
/// transaction. `now` comes from the caller's Clock.
class AccountStore {
 public:
  virtual ~AccountStore() = default;

  /// Signs up an address. Without a verified account, it gets an additional token and the welcome
  /// email, otherwise only an email that says so. Both cases do the same work, so that timing
  /// reveals nothing.
  virtual Result<void> sign_up(const SignUp& sign_up, Time now) = 0;
  /// Returns the address that the token was sent to, without consuming the token. Returns nothing
  /// if the token is unknown, used or expired.
  virtual Result<std::optional<std::string>> find_sign_up(const std::string& token_hash,
                                                          Time now) = 0;
  /// Confirms the address, sets the password and consumes all tokens of the account. Returns false
  /// if the token is unknown, used or expired.
  virtual Result<bool> verify(const std::string& token_hash, const std::string& password_hash,
                              Time now) = 0;
  virtual Result<std::optional<Account>> find_by_email(const std::string& email_key) = 0;
  virtual Result<std::optional<Account>> find_by_id(const std::string& user_id) = 0;

  virtual Result<void> open_session(const WebSession& session) = 0;
  /// Returns nothing also for an account that is disabled or was never verified.
  virtual Result<std::optional<SignedIn>> find_session(const std::string& token_hash, Time now) = 0;
  virtual Result<void> extend_session(const std::string& token_hash, Time expires_at) = 0;
  virtual Result<void> touch_session(const std::string& token_hash, Time used_at) = 0;
  virtual Result<void> close_session(const std::string& token_hash) = 0;

  virtual Result<Quota> quota_of(const std::string& user_id) = 0;
  /// Returns when the user consented to this version of the privacy notice, or nothing.
  virtual Result<std::optional<Time>> consent_at(const std::string& user_id,
                                                 const std::string& version) = 0;
  /// Records the consent, also in the audit log.
  virtual Result<void> give_consent(const std::string& user_id, const std::string& version,
                                    Time now) = 0;

  /// Records an attempt for every key. If a key is at its limit, records nothing and returns the
  /// time until the next attempt is allowed.
  virtual Result<std::optional<std::chrono::seconds>> note_attempt(
      const std::vector<AttemptLimit>& limits, Time now) = 0;
  /// Deletes all attempts for the key, or only the one recorded at `at`.
  virtual Result<void> forget_attempts(const std::string& key_hash, std::optional<Time> at) = 0;

  /// Removes old attempts, tokens, keys, audit entries, rendering time and unverified accounts.
  virtual Result<void> tidy(Time now) = 0;
};

/// The queue of outgoing email. Every function returns kUnavailable if the database is unavailable.
class MailStore {
 public:
  struct Queued {
    std::int64_t id = 0;
    int attempts = 0;
    Mail mail;
  };
  virtual ~MailStore() = default;
  /// Claims the next due email. No other caller gets it for `lease`.
  virtual Result<std::optional<Queued>> claim_mail(Time now, std::chrono::seconds lease) = 0;
  virtual Result<void> mail_sent(std::int64_t id) = 0;
  virtual Result<void> mail_failed(std::int64_t id, Time not_before) = 0;
};

}  // namespace diaphane::api
