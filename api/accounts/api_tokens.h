#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/accounts/accounts.h"
#include "api/accounts/token_scopes.h"

namespace diaphane::api {

/// Start of every API token, by which people and scanners for leaked secrets recognise it.
inline constexpr std::string_view kApiTokenPrefix = "diaphane_";

/// An API token as shown to its user.
struct ApiToken {
  std::string id;
  std::string name;
  std::vector<TokenScope> scopes;
  Time created_at, expires_at;
  std::optional<Time> used_at = {};
};

/// The account and rights of a token with which a request was sent.
struct TokenUse {
  ApiToken token;
  std::string user_id;
  std::string email;
  std::string consent_version;
  bool archive_access = false;
  bool for_fetch = false;  ///< only uploads what its user fetches from an archive
};

/// Every function returns kUnavailable if the database is unavailable. Each is one transaction,
/// which includes its entry in the audit log.
class ApiTokenStore {
 public:
  virtual ~ApiTokenStore() = default;
  /// Stores the token unless the account already has `most` valid ones. Returns false then, and
  /// kNotFound if the web session has ended: a new password ends it, and revokes all tokens.
  virtual Result<bool> create(const std::string& user_id, const std::string& session_id,
                              const ApiToken& token, const std::string& token_hash, int most,
                              const Mail& notification) = 0;
  /// Returns the valid tokens of an account, newest first.
  virtual Result<std::vector<ApiToken>> list(const std::string& user_id, Time now) = 0;
  /// Returns false if the account has no valid token with this ID.
  virtual Result<bool> revoke(const std::string& user_id, const std::string& id, Time now) = 0;
  /// Returns nothing for an unknown or expired token and for a disabled account.
  virtual Result<std::optional<TokenUse>> find(const std::string& token_hash, Time now) = 0;
  virtual Result<void> touch(const std::string& id, Time used_at) = 0;
};

/// API tokens, with which programs act for a user. Thread-safe.
class ApiTokens {
 public:
  struct Options {
    std::string account_url;  ///< address of the page where users revoke tokens
  };
  /// Maximum number of valid tokens per account.
  static constexpr int kMostTokens = 20;
  static constexpr int kMostDays = 365;

  struct Request {
    std::string name;
    std::vector<TokenScope> scopes;
    int days = 0;  ///< until the token expires
    std::string password;
    std::string code;  ///< only with two-factor authentication
  };
  struct Created {
    ApiToken token;
    std::string secret;  ///< the text that programs send; never stored
  };

  ApiTokens(ApiTokenStore& store, Accounts& accounts, const Clock& clock, const Signals& signals,
            Options options);

  /// Creates a token and notifies its user. Returns kInvalid for a wrong password, kCodeNeeded or
  /// kWrongCode with two-factor authentication, and kConflict for a full list.
  Outcome<Created> create(const Principal& who, const Request& request);
  Outcome<std::vector<ApiToken>> list(const Principal& who);
  /// Revokes a token and ends the streams that it opened.
  Outcome<void> revoke(const Principal& who, const std::string& id);

  /// Returns the user of a token for an operation of the contract. Returns kUnauthenticated for an
  /// invalid token, and kForbidden if no scope, or none of this token, permits the operation.
  Outcome<Principal> authenticate(std::string_view secret, std::string_view operation,
                                  Accounts::Renewal renewal);

 private:
  ApiTokenStore& store_;
  Accounts& accounts_;
  const Clock& clock_;
  const Signals& signals_;
  Options options_;
};

}  // namespace diaphane::api
