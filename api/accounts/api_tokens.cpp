#include "api/accounts/api_tokens.h"

#include <algorithm>
#include <array>

#include "api/accounts/account_mails.h"
#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> invalid_token() {
  return refuse(ProblemKind::kUnauthenticated, "The token is not valid.");
}

/// The operations of a token with which the PACS gateway uploads what a user fetches.
constexpr std::array<std::string_view, 4> kFetchOperations{"createDataSet", "getUploadOffset",
                                                           "appendToUpload", "terminateUpload"};

}  // namespace

ApiTokens::ApiTokens(ApiTokenStore& store, Accounts& accounts, const Clock& clock,
                     const Signals& signals, Options options)
    : store_(store),
      accounts_(accounts),
      clock_(clock),
      signals_(signals),
      options_(std::move(options)) {}

Outcome<ApiTokens::Created> ApiTokens::create(const Principal& who, const Request& request) {
  DIAPHANE_TRY(accounts_.confirm_password(who, "password", request.password));
  DIAPHANE_TRY(accounts_.confirm_code(who, request.code));
  const Time now = clock_.wall();
  Created created{
      {new_id(), request.name, request.scopes, now, now + std::chrono::hours(24) * request.days},
      std::string(kApiTokenPrefix) + random_hex(32)};
  const auto made = store_.create(
      who.user_id, who.session_id, created.token, blake2b(created.secret), kMostTokens,
      mails::api_token_created(who.language, who.email, request.name, options_.account_url));
  if (!made && made.error().code == ErrorCode::kNotFound) {
    return refuse(ProblemKind::kUnauthenticated, "You have been signed out. Please sign in again.");
  }
  if (!made) return refuse(made.error());
  if (!*made) {
    return refuse(ProblemKind::kConflict, "You can have at most " + std::to_string(kMostTokens) +
                                              " API tokens. Revoke one first.");
  }
  signals_.raise(Signal::kMail);
  return created;
}

Outcome<std::vector<ApiToken>> ApiTokens::list(const Principal& who) {
  auto found = store_.list(who.user_id, clock_.wall());
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<void> ApiTokens::revoke(const Principal& who, const std::string& id) {
  const auto none = [] { return refuse(ProblemKind::kNotFound, "API token not found."); };
  if (!is_id(id)) return none();
  const auto done = store_.revoke(who.user_id, id, clock_.wall());
  if (!done) return refuse(done.error());
  if (!*done) return none();
  signals_.raise(Signal::kSignOut);
  return {};
}

Outcome<Principal> ApiTokens::authenticate(std::string_view secret, std::string_view operation,
                                           Accounts::Renewal renewal) {
  if (!secret.starts_with(kApiTokenPrefix) || !is_token(secret.substr(kApiTokenPrefix.size()))) {
    return invalid_token();
  }
  const Time now = clock_.wall();
  const auto found = store_.find(blake2b(secret), now);
  if (!found) return refuse(found.error());
  if (!*found) return invalid_token();
  const ApiToken& token = (*found)->token;
  if ((*found)->for_fetch && !(*found)->archive_access) return invalid_token();
  const bool fetches = std::find(kFetchOperations.begin(), kFetchOperations.end(), operation) !=
                       kFetchOperations.end();
  if ((*found)->for_fetch && !fetches) {
    return refuse(ProblemKind::kForbidden, "This token only uploads.");
  }
  const auto needed = scope_of_operation(operation);
  if (!needed) {
    return refuse(ProblemKind::kForbidden,
                  "API tokens cannot do this. Sign in to Diaphane in a browser.");
  }
  if (std::find(token.scopes.begin(), token.scopes.end(), *needed) == token.scopes.end()) {
    return refuse(ProblemKind::kForbidden, "This API token does not have the scope " +
                                               std::string(to_string(*needed)) + ".");
  }
  if (renewal == Accounts::Renewal::kYes && (!token.used_at || now - *token.used_at > kUseNoted)) {
    if (auto done = store_.touch(token.id, now); !done) return refuse(done.error());
  }
  // The role of an administrator is left out, so that a leaked token never reaches other accounts.
  Principal principal;
  principal.user_id = (*found)->user_id;
  principal.email = (*found)->email;
  principal.session_id = token.id;
  principal.archive_access = (*found)->archive_access;
  principal.consented = (*found)->consent_version == accounts_.consent_version();
  return principal;
}

}  // namespace diaphane::api
