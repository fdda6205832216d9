#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "api/service/accounts.h"
#include "api/service/placement.h"

namespace diaphane::api {

/// A signed-in browser, as its person knows it.
struct BrowserSession {
  std::string id;
  std::string browser;  ///< "Firefox on Windows"; empty: not told
  Time created_at, used_at;
};

/// A sign-in that is over, by sign-out or by age.
struct ExpiredBrowser {
  std::string id, user_id;
};

/// What a mailed token is for.
struct TokenBearer {
  std::string user_id;
  std::string email;      ///< of the account, now
  std::string new_email;  ///< purpose "change"
};

struct EmailRequest {
  std::string user_id;
  std::string new_email, new_email_key;
  std::string token_hash;
  Time token_expires_at;
  Mail confirm;  ///< to the new address
  Mail taken;    ///< to the new address, when it has an account
  Mail to_old;
};

/// Every function: kUnavailable when the database is away. Each is one transaction, its entry in
/// the audit log included.
class AccountChangeStore {
 public:
  virtual ~AccountChangeStore() = default;
  /// The same work whether the address has an account or not: one statement, one mail.
  virtual Result<void> request_reset(const std::string& email_key, const std::string& token_hash,
                                     Time expires_at, const Mail& known, const Mail& unknown) = 0;
  /// Does not use the token up. Nothing: unknown, used, expired or of another purpose.
  virtual Result<std::optional<TokenBearer>> find_token(const std::string& token_hash,
                                                        const std::string& purpose, Time now) = 0;
  /// Uses the token up, ends every browser's session and forgets other tokens. False: the token has
  /// gone meanwhile.
  virtual Result<bool> reset(const std::string& token_hash, const std::string& password_hash,
                             const Mail& told, Time now) = 0;
  /// Ends every other browser's session and forgets tokens.
  virtual Result<void> change_password(const std::string& user_id, const std::string& password_hash,
                                       const std::string& kept_session, const Mail& told,
                                       Time now) = 0;
  virtual Result<void> request_email(const EmailRequest& request, Time now) = 0;
  /// False: the token has gone, or the address was taken meanwhile.
  virtual Result<bool> confirm_email(const std::string& token_hash,
                                     const std::string& new_email_key, const Mail& to_old,
                                     Time now) = 0;
  virtual Result<std::vector<BrowserSession>> browser_sessions(const std::string& user_id,
                                                               Time now) = 0;
  /// False: there is none of that id.
  virtual Result<bool> end_browser_session(const std::string& user_id, const std::string& id) = 0;
  virtual Result<void> end_browser_sessions(const std::string& user_id, Time now) = 0;
  /// At most `limit`, the oldest first; they are kept until they are forgotten.
  virtual Result<std::vector<ExpiredBrowser>> expired_browsers(Time now, int limit) = 0;
  virtual Result<void> forget_browser(const std::string& id) = 0;
};

/// What a person changes of the own account. Thread-safe.
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
                 PasswordHasher& hasher, Placement& placement, const Clock& clock, Options options);

  /// Success whoever has an account, after the same work. `address` is the peer's.
  Outcome<void> request_reset(const std::string& email, const std::string& address);
  /// kLinkExpired. Signs out everywhere.
  Outcome<void> reset(const std::string& token, const std::string& password);
  Outcome<void> change_password(const Principal& who, const std::string& current,
                                const std::string& password);
  /// Mails a link to the new address and tells the old one.
  Outcome<void> request_email(const Principal& who, const std::string& new_email,
                              const std::string& password);
  /// Only by the account that asked: whoever reads the mail of the new address must not be able to
  /// give it to a stranger's account (docs/adr/0034). kLinkExpired, kForbidden.
  Outcome<void> confirm_email(const Principal& who, const std::string& token);

  Outcome<std::vector<BrowserSession>> browser_sessions(const Principal& who);
  Outcome<void> end_browser_session(const Principal& who, const std::string& id);
  /// This one, too; and every picture that is open.
  Outcome<void> sign_out_everywhere(const Principal& who);

  /// Ends the streams of every browser whose sign-in is over, and forgets it. What cannot be ended
  /// now, because Redis is away, is ended by a later call.
  void end_expired_browsers();

  void on_mail(std::function<void()> wake) { wake_mailer_ = std::move(wake); }

 private:
  void end_pictures(const std::string& user_id);
  std::string forgot_url() const { return options_.public_url + "/forgot"; }

  AccountChangeStore& store_;
  AccountStore& attempts_;
  Accounts& accounts_;
  PasswordHasher& hasher_;
  Placement& placement_;
  const Clock& clock_;
  Options options_;
  std::function<void()> wake_mailer_ = [] {};
};

}  // namespace diaphane::api
