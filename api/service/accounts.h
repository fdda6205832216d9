#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "api/service/account_store.h"
#include "api/service/code_check.h"
#include "api/service/password.h"
#include "api/service/problem.h"
#include "api/service/secrets.h"
#include "common/clock.h"

namespace diaphane::api {

/// Who asks: a person, the sample's operator, or (neither of the two) nobody.
struct Principal {
  std::string user_id;
  bool sample_operator = false;
  std::string email;
  std::string csrf_token;       ///< of the web session
  bool renewed = false;         ///< the session was extended: give the cookie its new age
  bool administrator = false;   ///< beside being a person: the role, and a second factor
  std::string session_id = {};  ///< of the web session, as its person knows it
  bool second_factor = false;   ///< the account has one
  /// Has an administrator's role and no second factor: `administrator` is false until it is set up.
  bool administrator_waits = false;
};

/// Signing up, in and out. Thread-safe.
class Accounts {
 public:
  struct Options {
    std::string public_url;  ///< origin, for links in mails: "http://127.0.0.1:8080"
    std::chrono::seconds link_life = std::chrono::hours(48);
    std::chrono::seconds session_life = std::chrono::hours(24 * 14);   ///< without use
    std::chrono::seconds session_limit = std::chrono::hours(24 * 30);  ///< in all
    /// Of who has the administrator's role (ASVS 3.3.2 at level 2).
    std::chrono::seconds administrator_idle = std::chrono::minutes(30);
    std::chrono::seconds administrator_limit = std::chrono::hours(12);
    std::chrono::seconds window = std::chrono::minutes(15);
    int failures_by_account = 10;  ///< in `window`; of strangers, and of each known browser
    int failures_by_address = 50;  ///< in `window`
    int sign_ups_by_address = 30;  ///< in `window`
    /// Sign-up mails to one address in `window`. Every one of them holds a link that works.
    int mails_by_recipient = 4;
  };

  struct Opened {
    std::string token;  ///< for the cookie; not kept anywhere here
    Principal principal;
    /// For the cookie by which this browser is known to have signed in to this account; not kept
    /// anywhere here. It ends with the account's password.
    std::string known_browser;
  };

  /// `key` signs the cookies of known browsers.
  Accounts(AccountStore& store, PasswordHasher& hasher, CodeCheck& codes, const SealingKey& key,
           const Clock& clock, Options options);

  /// Mails a link. kInvalid for what can be said without knowing any account; else success, whoever
  /// has an account. `address` is the peer's, for the limit.
  Outcome<void> sign_up(const std::string& email, const std::string& address);
  /// Whoever holds a mailed token reads the mail of the address: only they choose its password
  /// (docs/adr/0034). kLinkExpired when the token is unknown, used or too old.
  Outcome<void> verify(const std::string& token, const std::string& password);
  /// kWrongCredentials, also while the address is not confirmed; kDisabled, kTooManyAttempts; with
  /// the right password of an account that has a second factor, kCodeNeeded without a code and
  /// kWrongCode with a wrong one. `browser` is a rough name. Failures of a browser that
  /// `known_browser` shows to have signed in to this account before are counted for it alone:
  /// strangers' failures do not lock it out.
  Outcome<Opened> sign_in(const std::string& email, const std::string& password,
                          const std::string& code, const std::string& address,
                          const std::string& browser = "", const std::string& known_browser = "");
  /// The password once more, before what cannot be undone; a wrong one is a fault of `field`.
  /// Failures are counted for this sign-in alone.
  Outcome<void> confirm_password(const Principal& who, const std::string& field,
                                 const std::string& password);
  Outcome<void> sign_out(const std::string& token);
  /// Whether the use of a session is noted and its expiry moved.
  enum class Renewal { kYes, kNo };
  /// kUnauthenticated for a cookie that is forged, unknown or expired. Slides the expiry.
  Outcome<Principal> authenticate(const std::string& token, Renewal renewal = Renewal::kYes);
  Outcome<Quota> quota_of(const std::string& user_id);

  std::chrono::seconds session_life() const { return options_.session_life; }
  /// Called after a mail was queued, so that it need not wait for the next look at the queue.
  void on_mail(std::function<void()> wake) { wake_mailer_ = std::move(wake); }
  /// Called after a browser was signed out: its streams are to be ended.
  void on_sign_out(std::function<void()> call) { signed_out_ = std::move(call); }

 private:
  /// kCodeNeeded, kWrongCode, or nothing where no code is needed or the right one was given.
  Outcome<void> check_code(const Account& account, const std::string& code);
  /// Under which keys an attempt at a password is counted.
  struct Counters {
    std::string whole;                   ///< forgotten after a right password
    std::optional<std::string> address;  ///< of the peer; keeps its other failures
  };
  /// Whether the password is right; nothing that a caller says may depend on whether `account` is
  /// there.
  Outcome<bool> is_right(const std::optional<Account>& account, const Counters& counters,
                         const std::string& password, Time now);
  /// The cookie's random half, when the whole was given to this browser for this account.
  std::optional<std::string> known(const std::optional<Account>& account,
                                   const std::string& cookie) const;
  std::string browser_token(const Account& account, const std::string& nonce) const;

  AccountStore& store_;
  PasswordHasher& hasher_;
  CodeCheck& codes_;
  const SealingKey& key_;
  const Clock& clock_;
  Options options_;
  std::function<void()> wake_mailer_ = [] {};
  std::function<void()> signed_out_ = [] {};
};

}  // namespace diaphane::api
