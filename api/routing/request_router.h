#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "api/accounts/accounts.h"
#include "api/accounts/api_tokens.h"
#include "api/routing/message.h"
#include "api/shared/idempotency.h"
#include "api/shared/problem.h"

namespace diaphane::api {

/// The authentication that a route requires. Where the cookie counts, so does an API token whose
/// scope permits the operation (token_scopes.h).
enum class Access {
  kAnyone,  ///< ignores the cookie
  /// Ignores the cookie. The body_check requires the key of a participant in a study, so a body may
  /// be larger than kAnyoneBodyBytes.
  kParticipant,
  kAnyoneOrPerson,    ///< works with the cookie or without an account
  kOwnAccount,        ///< requires the cookie, even before the consent to the privacy notice
  kPerson,            ///< requires the cookie and, except to read and delete, that consent
  kPersonOrOperator,  ///< as kPerson, or requires the sample token
  kResearcher,        ///< as kPerson, and requires the researcher's role
  kArchive,           ///< as kPerson, and requires access to the hospital's archives
  kAdministrator,     ///< requires the cookie of an administrator
};

/// One operation of api/openapi.yaml. The handler parses the request, calls a service and replies.
/// The principal is empty for kAnyone.
struct Route {
  using Handler = std::function<Outcome<Response>(const Request&, const Principal&)>;
  std::string method;
  std::string pattern;    ///< "/v1/data-sets/{data_set_id}"
  std::string operation;  ///< its operationId in api/openapi.yaml
  Access access = Access::kPerson;
  Handler handler;
  std::vector<std::string> query;         ///< the allowed parameters
  std::int64_t body_limit = 1024 * 1024;  ///< bytes; for kAnyone at most kAnyoneBodyBytes
  /// Checks, with only the head of the request, whether a body of this size would be accepted. The
  /// edge calls it before it reads the body, and the handler checks again.
  std::function<Outcome<void>(const Request&, const Principal&, std::int64_t bytes)> body_check =
      nullptr;
};

/// Maximum body size on a route that anyone can use. The edge buffers it in memory.
inline constexpr std::int64_t kAnyoneBodyBytes = 16 * 1024;

/// The path where the edge asks whether it may read a request's body. It is outside /v1, so that no
/// client can reach it. X-Original-Method, X-Original-Target and X-Original-Length describe the
/// request, and the other headers are copied from it. The response is 204, with the account (if
/// any) in X-Account, or the error response for the request itself.
inline constexpr std::string_view kBodyGate = "/edge/body";

/// Measurements of a request.
struct Measured {
  std::string operation;  ///< or "none"
  int status = 0;
  double seconds = 0;
  std::int64_t body_bytes = 0;
};

/// Does everything around a handler: routing, authentication, CSRF protection, problem documents,
/// request IDs, the log line and metrics. Independent of the HTTP library. Thread-safe once all
/// routes are added.
class RequestRouter {
 public:
  struct Options {
    std::string public_url;       ///< origin of the page
    std::string sample_token;     ///< if empty, no request is accepted as the sample's operator
    ApiTokens* tokens = nullptr;  ///< if null, no API token is valid
    std::function<void(const Measured&)> measure = [](const Measured&) {};
  };

  /// A request with an accepted head. Its body may be read, up to the limit.
  struct Admitted {
    const Route* route = nullptr;
    Request request;
    bool asks_for_body = false;  ///< a query of the edge (kBodyGate), not the request itself
  };
  /// The admitted request, or an immediate response: a refusal or the answer to OPTIONS.
  using Admission = std::variant<Admitted, Response>;

  RequestRouter(Accounts& accounts, Options options);

  void add(std::vector<Route> routes);

  /// Checks the head: URL, method, query parameters and the announced length of the body.
  Admission admit(Head head) const;
  /// Runs the handler and may block. Every outcome, even a bug, becomes a response.
  Response serve(Admitted& admitted) const;
  /// Logs a refusal from outside a handler (overload, a broken body) and returns its response.
  Response refusal(const Problem& problem, const Request& request) const;

  /// Returns the session cookie `diaphane=...`. Over HTTPS, its name is `__Host-diaphane`, which no
  /// other host and no plain connection can set. An empty token deletes the cookie.
  std::string cookie(const std::string& token) const;
  std::string token_of(const Head& head) const;
  /// Returns `diaphane_browser=...`, which identifies a browser that has signed in before
  /// (docs/adr/0007). It is sent with the other cookie and outlives it.
  std::string browser_cookie(const std::string& known_browser) const;
  std::string known_browser_of(const Head& head) const;

 private:
  Admission admit_request(Head head) const;
  Outcome<Response> decide_body(const Route& route, const Request& request) const;
  Outcome<Principal> identify(const Route& route, const Request& request,
                              Accounts::Renewal renewal) const;
  /// Returns the author of a request with an Authorization header.
  Outcome<Principal> identify_bearer(const Route& route, const Request& request,
                                     Accounts::Renewal renewal) const;
  Outcome<void> check_origin(const Request& request) const;
  std::string set_cookie(const std::string& name, const std::string& value,
                         std::chrono::seconds age) const;
  static std::string cookie_of(const Head& head, std::string_view name);
  Response finish(Response response, const Request& request) const;

  Accounts& accounts_;
  Options options_;
  bool secure_;
  std::string cookie_name_, browser_cookie_name_;
  std::vector<Route> routes_;
};

/// Returns the Idempotency-Key of a request and the cookie or API token from which token_for
/// derives secrets.
Outcome<IdempotencyScope> idempotency_scope_of(const Request& request, const RequestRouter& router);

}  // namespace diaphane::api
