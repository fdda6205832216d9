#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/accounts/account_store.h"
#include "api/accounts/code_check.h"
#include "api/accounts/language.h"
#include "api/accounts/password.h"
#include "api/shared/client.h"
#include "api/shared/problem.h"
#include "api/shared/secrets.h"
#include "api/shared/signals.h"
#include "common/clock.h"

namespace diaphane::api {

/// The author of a request: a user, the operator of the sample, or nobody.
struct Principal {
  std::string user_id;
  bool sample_operator = false;
  std::string email;
  std::string csrf_token;       ///< of the web session
  bool renewed = false;         ///< the session was extended, so the cookie needs a new age
  bool administrator = false;   ///< has the role and two-factor authentication
  std::string session_id = {};  ///< public ID of the web session
  bool second_factor = false;   ///< the account has two-factor authentication
  /// Has the administrator role without two-factor authentication. Until it is on, `administrator`
  /// is false.
  bool administrator_waits = false;
  bool consented = false;                  ///< to the current privacy notice
  bool researcher = false;                 ///< has the role, with which they run studies
  bool archive_access = false;             ///< may use the hospital's archives
  Language language = Language::kEnglish;  ///< of the request, with or without an account
  Client client = {};                      ///< of the request, likewise
};

/// Version of the privacy notice's template, which is its date (frontend/public/legal).
inline constexpr const char* kPrivacyTemplate = "2026-11-27";

/// Minimum interval between two updates of the last use of a web session or an API token.
inline constexpr std::chrono::minutes kUseNoted{10};

/// Whether a user agrees to the processing of health data as the privacy notice describes it.
enum class Consent { kGiven, kMissing };

/// Handles sign-up, sign-in, consent and sign-out. Thread-safe.
class Accounts {
 public:
  struct Options {
    std::string public_url;  ///< origin of links in emails, such as "http://127.0.0.1:8080"
    std::chrono::seconds link_life = std::chrono::hours(48);
    std::chrono::seconds session_life = std::chrono::hours(24 * 14);   ///< maximum idle time
    std::chrono::seconds session_limit = std::chrono::hours(24 * 30);  ///< maximum lifetime
    /// For users with the administrator role (ASVS 3.3.2, level 2).
    std::chrono::seconds administrator_idle = std::chrono::minutes(30);
    std::chrono::seconds administrator_limit = std::chrono::hours(12);
    std::chrono::seconds window = std::chrono::minutes(15);
    /// Per account in `window`, counted separately for each known browser and for all others.
    int failures_by_account = 10;
    int failures_by_address = 50;  ///< in `window`
    int sign_ups_by_address = 30;  ///< in `window`
    /// Sign-up emails to one address in `window`. Each contains a valid link.
    int mails_by_recipient = 4;
    /// Version of the privacy notice that users have to agree to.
    std::string consent_version = kPrivacyTemplate;
  };

  struct Opened {
    std::string token;  ///< for the cookie; never stored
    Principal principal;
    /// Value of the cookie that shows that this browser has signed in to this account before. It is
    /// never stored and becomes invalid when the password changes.
    std::string known_browser;
  };

  /// `key` signs the cookies of known browsers.
  Accounts(AccountStore& store, PasswordHasher& hasher, CodeCheck& codes, const SealingKey& key,
           const Clock& clock, const Signals& signals, Options options);

  /// Sends a link. Returns kInvalid only without consent or for errors that reveal no account, and
  /// otherwise succeeds, whether or not the account exists. `address` is the client's, for the rate
  /// limit. `language` is that of the email.
  Outcome<void> sign_up(const std::string& email, Consent consent, const std::string& address,
                        Language language = Language::kEnglish);
  /// Confirms the address and sets the password. Only the holder of the emailed token can do this,
  /// because it proves access to the mailbox (docs/adr/0034). Signs in the browser. Returns
  /// kLinkExpired for an unknown, used or expired token, and kDisabled for a disabled account.
  /// `browser` is an approximate name.
  Outcome<Opened> verify(const std::string& token, const std::string& password,
                         const std::string& browser = "");
  /// Returns kWrongCredentials (also while the address is not confirmed), kDisabled or
  /// kTooManyAttempts. With the correct password of an account that has two-factor authentication,
  /// returns kCodeNeeded without a code and kWrongCode for a wrong one. `browser` is an approximate
  /// name. If `known_browser` shows that this browser has signed in to this account before, its
  /// failures are counted separately, so that the failures of strangers do not lock it out.
  /// `language` is that of emails about the code.
  Outcome<Opened> sign_in(const std::string& email, const std::string& password,
                          const std::string& code, const std::string& address,
                          const std::string& browser = "", const std::string& known_browser = "",
                          Language language = Language::kEnglish);
  /// Checks the password again before a sensitive action. A wrong password is an error of `field`.
  /// Failures are counted only for this web session.
  Outcome<void> confirm_password(const Principal& who, const std::string& field,
                                 const std::string& password);
  /// Checks a code again if the account has two-factor authentication. Returns kCodeNeeded without
  /// a code and kWrongCode for a wrong one.
  Outcome<void> confirm_code(const Principal& who, const std::string& code);
  Outcome<void> sign_out(const std::string& token);
  /// Whether to record the use of a session and to extend its expiry.
  enum class Renewal { kYes, kNo };
  /// Returns the user of a session cookie, or kUnauthenticated if it is invalid or expired.
  Outcome<Principal> authenticate(const std::string& token, Renewal renewal = Renewal::kYes);
  Outcome<Quota> quota_of(const std::string& user_id);
  const std::string& consent_version() const { return options_.consent_version; }
  /// Returns when the user consented to the current privacy notice, or nothing.
  Outcome<std::optional<Time>> consent_at(const Principal& who);
  /// Returns kInvalid for any version but the current one, because the user has read another text.
  Outcome<void> give_consent(const Principal& who, const std::string& version);

  std::chrono::seconds session_life() const { return options_.session_life; }

 private:
  /// Opens a web session for a user who has proved who they are. `known_browser` is the random half
  /// of the cookie of a known browser.
  Outcome<Opened> open(const Account& account, const std::string& browser,
                       const std::string& known_browser);
  /// Returns kCodeNeeded, kWrongCode, or nothing if no code is needed or the code is correct.
  Outcome<void> check_code(const Account& account, const std::string& code, Language language);
  /// The keys for which a password attempt is counted.
  struct Counters {
    std::string account_key;                 ///< reset after a correct password
    std::optional<std::string> address_key;  ///< of the client; keeps its other failures
  };
  /// Returns whether the password is correct. No response may reveal whether `account` exists.
  Outcome<bool> is_right(const std::optional<Account>& account, const Counters& counters,
                         const std::string& password, Time now);
  /// Returns the random half of the cookie if it was issued to this browser for this account.
  std::optional<std::string> known(const std::optional<Account>& account,
                                   const std::string& cookie) const;
  std::string browser_token(const Account& account, const std::string& nonce) const;

  AccountStore& store_;
  PasswordHasher& hasher_;
  CodeCheck& codes_;
  const SealingKey& key_;
  const Clock& clock_;
  const Signals& signals_;
  Options options_;
};

}  // namespace diaphane::api
