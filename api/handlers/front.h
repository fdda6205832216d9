#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "api/handlers/message.h"
#include "api/service/accounts.h"
#include "api/service/idempotency.h"
#include "api/service/problem.h"

namespace diaphane::api {

/// Who may ask.
enum class Access {
  kAnyone,            ///< the cookie is not looked at
  kAnyoneOrPerson,    ///< with the cookie, or as nobody
  kPerson,            ///< with the cookie
  kPersonOrOperator,  ///< with the cookie, or with the sample's token
  kAdministrator,     ///< with the cookie of one
};

/// One operation of api/openapi.yaml. The handler parses, calls a service, replies; the principal
/// is empty for kAnyone.
struct Route {
  using Handler = std::function<Outcome<Response>(const Request&, const Principal&)>;
  std::string method;
  std::string pattern;    ///< "/v1/data-sets/{data_set_id}"
  std::string operation;  ///< its operationId
  Access access = Access::kPerson;
  Handler handler;
  std::vector<std::string> query;         ///< the parameters it knows
  std::int64_t body_limit = 1024 * 1024;  ///< bytes; without a principal at most kAnyoneBodyBytes
  /// Checks from the head alone whether a body of so many bytes may be sent at all. The edge asks
  /// before it reads the body; the handler checks again.
  std::function<Outcome<void>(const Request&, const Principal&, std::int64_t bytes)> body_check =
      nullptr;
};

/// The largest body on a route that anyone may use. The edge holds it in memory.
inline constexpr std::int64_t kAnyoneBodyBytes = 16 * 1024;

/// Where the edge asks whether it may read a request's body. It is outside of /v1, so that no
/// client reaches it. X-Original-Method, X-Original-Target and X-Original-Length describe the
/// request; the other headers are its own. The answer is 204, with the account in X-Account where
/// there is one, or what the request itself is to be answered with.
inline constexpr std::string_view kBodyGate = "/edge/body";

/// What was measured of a request.
struct Measured {
  std::string operation;  ///< or "none"
  int status = 0;
  double seconds = 0;
  std::int64_t body_bytes = 0;
};

/// What comes before and after every handler: the route, who asks, cross-site requests, problem
/// documents, request ids, the log line, metrics. Knows no HTTP library; thread-safe once the
/// routes are added.
class Front {
 public:
  struct Options {
    std::string public_url;    ///< the page's origin
    std::string sample_token;  ///< empty: nobody is the sample's operator
    std::function<void(const Measured&)> measure = [](const Measured&) {};
  };

  /// A request whose head was let in; its body may be read, up to the limit.
  struct Admitted {
    const Route* route = nullptr;
    Request request;
    bool asks_for_body = false;  ///< the edge's question (kBodyGate), not the request itself
  };
  /// Or the answer at once.
  using Admission = std::variant<Admitted, Response>;

  Front(Accounts& accounts, Options options);

  void add(std::vector<Route> routes);

  /// From the head alone: 400, 404, 405, and a body that is announced as too large.
  Admission admit(Head head) const;
  /// Runs the handler; may block. Every outcome is a response, also a defect.
  Response serve(Admitted& admitted) const;
  /// The answer when something other than a handler refuses (no room, a broken body).
  Response refusal(const Problem& problem, const Request& request) const;

  /// `diaphane=...` and its attributes, under https `__Host-diaphane=...`, which no other host and
  /// no plain connection can set; an empty token removes it.
  std::string cookie(const std::string& token) const;
  std::string token_of(const Head& head) const;
  /// `diaphane_browser=...`: by it a browser that has signed in is known again (docs/adr/0007). It
  /// is sent beside the other and outlives it.
  std::string browser_cookie(const std::string& known_browser) const;
  std::string known_browser_of(const Head& head) const;

 private:
  Admission admit_request(Head head) const;
  Outcome<Response> decide_body(const Route& route, const Request& request) const;
  Outcome<Principal> identify(const Route& route, const Request& request,
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

/// The Idempotency-Key of a request, with what makes a secret the same again: the cookie.
Outcome<Once> once_of(const Request& request, const Front& front);

}  // namespace diaphane::api
