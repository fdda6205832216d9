#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/accounts/accounts.h"
#include "api/shared/placement.h"
#include "api/shared/signals.h"

namespace diaphane::api {

/// A signed-in browser, as shown to its user.
struct BrowserSession {
  std::string id;
  std::string browser;  ///< for example "Firefox on Windows"; empty if unknown
  Time created_at, used_at;
};

/// A web session or an API token that was ended or has expired.
struct ExpiredBrowser {
  std::string id, user_id;
};

/// The account that an emailed token belongs to.
struct TokenBearer {
  std::string user_id;
  std::string email;      ///< current address of the account
  std::string new_email;  ///< for the purpose "change"
};

struct EmailRequest {
  std::string user_id;
  std::string new_email, new_email_key;
  std::string token_hash;
  Time token_expires_at;
  Mail confirm;  ///< sent to the new address
  Mail taken;    ///< sent to the new address if it already has an account
  Mail to_old;
};

/// The emails that a request to reset a password can lead to, all to the same address.
struct ResetMails {
  Mail reset;
  Mail disabled;  ///< if an administrator has disabled the account
  Mail unknown;   ///< if there is no confirmed account
};

/// Every function returns kUnavailable if the database is unavailable. Each is one transaction,
/// which includes its entry in the audit log.
class AccountChangeStore {
 public:
  virtual ~AccountChangeStore() = default;
  /// Queues the email that fits: only `mails.reset` has a link that works. Does the same work
  /// whether or not an account exists.
  virtual Result<void> request_reset(const std::string& email_key, const std::string& token_hash,
                                     Time expires_at, const ResetMails& mails) = 0;
  /// Returns the account of a token without consuming it, or nothing if the token is unknown, used,
  /// expired or for another purpose.
  virtual Result<std::optional<TokenBearer>> find_token(const std::string& token_hash,
                                                        const std::string& purpose, Time now) = 0;
  /// Consumes the token, sets the password, ends all web sessions and deletes other tokens. Returns
  /// false if the token no longer exists.
  virtual Result<bool> reset(const std::string& token_hash, const std::string& password_hash,
                             const Mail& notification, Time now) = 0;
  /// Sets the password, ends all other web sessions and deletes all emailed tokens.
  virtual Result<void> change_password(const std::string& user_id, const std::string& password_hash,
                                       const std::string& kept_session, const Mail& notification,
                                       Time now) = 0;
  virtual Result<void> request_email(const EmailRequest& request, Time now) = 0;
  /// Changes the address. Returns false if the token no longer exists or the address is now taken.
  virtual Result<bool> confirm_email(const std::string& token_hash,
                                     const std::string& new_email_key, const Mail& to_old,
                                     Time now) = 0;
  virtual Result<std::vector<BrowserSession>> browser_sessions(const std::string& user_id,
                                                               Time now) = 0;
  /// Ends a web session of the user. Returns false if none has this ID.
  virtual Result<bool> end_browser_session(const std::string& user_id, const std::string& id) = 0;
  virtual Result<void> end_browser_sessions(const std::string& user_id, Time now) = 0;
  /// Returns at most `limit` ended sessions, oldest first. They stay until forget_browser() is
  /// called.
  virtual Result<std::vector<ExpiredBrowser>> expired_browsers(Time now, int limit) = 0;
  virtual Result<void> forget_browser(const std::string& id) = 0;
};

/// Changes that users make to their own accounts. Thread-safe.
class AccountChanges {
 public:
  struct Options {
    std::string public_url;
    std::chrono::seconds reset_life = std::chrono::hours(1);
    std::chrono::seconds change_life = std::chrono::hours(48);
    std::chrono::seconds window = std::chrono::minutes(15);
    int resets_by_address = 30;  ///< in `window`
    int mails_by_recipient = 4;  ///< in `window`
  };

  AccountChanges(AccountChangeStore& store, AccountStore& attempts, Accounts& accounts,
                 PasswordHasher& hasher, Placement& placement, const Clock& clock,
                 const Signals& signals, Options options);

  /// Does the same work whether or not the account exists. `address` is the client's IP address.
  /// `language` is that of the email.
  Outcome<void> request_reset(const std::string& email, const std::string& address,
                              Language language = Language::kEnglish);
  /// Sets a new password and signs out everywhere. Returns kLinkExpired for an unknown token.
  Outcome<void> reset(const std::string& token, const std::string& password,
                      Language language = Language::kEnglish);
  Outcome<void> change_password(const Principal& who, const std::string& current,
                                const std::string& password);
  /// Sends a link to the new address and notifies the old one.
  Outcome<void> request_email(const Principal& who, const std::string& new_email,
                              const std::string& password);
  /// Works only for the account that requested the change, so that nobody assigns their address to
  /// a stranger's account (docs/adr/0034). Returns kLinkExpired or kForbidden.
  Outcome<void> confirm_email(const Principal& who, const std::string& token);

  Outcome<std::vector<BrowserSession>> browser_sessions(const Principal& who);
  Outcome<void> end_browser_session(const Principal& who, const std::string& id);
  /// Signs out all browsers, including this one, and ends all open sessions.
  Outcome<void> sign_out_everywhere(const Principal& who);

  /// Ends the streams of web sessions and API tokens that are over, then deletes their rows.
  /// Retries in a later call if Redis is unavailable.
  void end_expired_browsers();

 private:
  void end_pictures(const std::string& user_id);
  std::string forgot_url() const { return options_.public_url + "/forgot"; }

  AccountChangeStore& store_;
  AccountStore& attempts_;
  Accounts& accounts_;
  PasswordHasher& hasher_;
  Placement& placement_;
  const Clock& clock_;
  const Signals& signals_;
  Options options_;
};

}  // namespace diaphane::api
