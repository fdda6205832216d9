#include "api/routing/request_router.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <exception>
#include <map>
#include <optional>

#include "api/accounts/language.h"
#include "api/routing/problem_document.h"
#include "api/routing/request_fields.h"
#include "api/routing/target.h"
#include "api/shared/secrets.h"
#include "common/ids.h"
#include "common/log.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

constexpr std::size_t kMaxResponseBytes = 1024 * 1024;
constexpr auto kBrowserKnown = std::chrono::hours(24 * 180);

std::string request_id_of(const Head& head) {
  const std::string_view given = head.header("x-request-id");
  const bool plain = given.size() >= 8 && given.size() <= 64 &&
                     std::all_of(given.begin(), given.end(), [](char c) {
                       return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                              (c >= '0' && c <= '9') || c == '-';
                     });
  return plain ? std::string(given) : random_hex(16);
}

Client client_of(const Head& head) {
  const std::string_view address = head.header("x-forwarded-for");
  std::string browser(head.header("x-browser").substr(0, 60));
  std::erase_if(browser, [](char c) { return c < 0x20 || c > 0x7e; });
  return {address.empty() ? "local" : std::string(address), std::move(browser)};
}

bool is_safe(const std::string& method) {
  return method == "GET" || method == "HEAD" || method == "OPTIONS";
}

/// Returns the Content-Length, or 0 if it is absent. Admission has checked that it is a number.
std::int64_t announced_bytes(const Request& request) {
  std::int64_t length = 0;
  const std::string_view text = request.header("content-length");
  std::from_chars(text.data(), text.data() + text.size(), length);
  return length;
}

std::int64_t body_limit_of(const Route& route) {
  return route.access == Access::kAnyone ? std::min(route.body_limit, kAnyoneBodyBytes)
                                         : route.body_limit;
}

/// The routes whose pattern matches the path of a request.
struct PathMatch {
  const Route* route = nullptr;  ///< the one that also matches the method
  std::map<std::string, std::string> parameters;
  std::string allowed;  ///< the methods of all matching routes

  void allow(const std::string& method) { allowed += (allowed.empty() ? "" : ", ") + method; }
};

PathMatch match_routes(const std::vector<Route>& routes, const std::string& method,
                       const std::string& path) {
  PathMatch match;
  for (const Route& route : routes) {
    auto parameters = match_path(route.pattern, path);
    if (!parameters) continue;
    match.allow(route.method);
    if (route.method == "GET") match.allow("HEAD");
    // A HEAD request also matches a GET route; finish() drops the body. The first match wins.
    const bool fits = route.method == method || (method == "HEAD" && route.method == "GET");
    if (!fits || match.route) continue;
    match.route = &route;
    match.parameters = *std::move(parameters);
  }
  return match;
}

std::optional<Problem> problem_of_query(const Route& route, const Request& request) {
  for (const auto& [name, value] : request.query) {
    if (std::find(route.query.begin(), route.query.end(), name) != route.query.end()) continue;
    return Problem{ProblemKind::kInvalid,
                   "The request contains invalid values.",
                   {{"query", "contains an unknown parameter"}},
                   {}};
  }
  return std::nullopt;
}

std::optional<Problem> problem_of_length(const Route& route, const Request& request) {
  // The edge buffers bodies and sends their length, so chunked bodies never arrive here.
  if (!request.header("transfer-encoding").empty()) {
    return Problem{
        ProblemKind::kBadRequest, "A request with a body needs a Content-Length header.", {}, {}};
  }
  const std::string_view text = request.header("content-length");
  if (text.empty()) return std::nullopt;
  std::int64_t length = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), length);
  if (error != std::errc() || end != text.data() + text.size() || length < 0) {
    return Problem{ProblemKind::kBadRequest, "Content-Length is not a valid number.", {}, {}};
  }
  if (const std::int64_t limit = body_limit_of(route); length > limit) {
    return Problem{ProblemKind::kBodyTooLarge,
                   "The body has at most " + std::to_string(limit) + " bytes here.",
                   {},
                   {}};
  }
  return std::nullopt;
}

bool is_header_text(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7f; });
}

/// Returns whether a route needs consent. Without it, users can still read and delete their data.
bool needs_consent(const Route& route) {
  const bool consenting = route.access == Access::kPerson ||
                          route.access == Access::kPersonOrOperator ||
                          route.access == Access::kResearcher || route.access == Access::kArchive;
  return consenting && !is_safe(route.method) && route.method != "DELETE";
}

tl::unexpected<Problem> consent_needed() {
  return refuse(ProblemKind::kConsentNeeded,
                "Read the current privacy notice and consent to it to continue.");
}

Outcome<void> check_archive_access(const Route& route, const Principal& principal) {
  if (route.access != Access::kArchive || principal.archive_access) return {};
  return refuse(ProblemKind::kForbidden,
                "Your account has no access to the hospital's archives. An administrator can give "
                "it to you.");
}

/// Returns what follows "Bearer " in the Authorization header, or nothing for another header.
std::string_view bearer_of(const Head& head) {
  constexpr std::string_view kBearer = "Bearer ";
  const std::string_view authorization = head.header("authorization");
  return authorization.starts_with(kBearer) ? authorization.substr(kBearer.size())
                                            : std::string_view();
}

}  // namespace

RequestRouter::RequestRouter(Accounts& accounts, Options options)
    : accounts_(accounts),
      options_(std::move(options)),
      secure_(options_.public_url.starts_with("https://")),
      cookie_name_(secure_ ? "__Host-diaphane" : "diaphane"),
      browser_cookie_name_(cookie_name_ + "_browser") {}

void RequestRouter::add(std::vector<Route> routes) {
  std::move(routes.begin(), routes.end(), std::back_inserter(routes_));
}

RequestRouter::Admission RequestRouter::admit(Head head) const {
  if (head.target != kBodyGate) return admit_request(std::move(head));
  head.method = head.header("x-original-method");
  head.target = head.header("x-original-target");
  head.headers["content-length"] = head.header("x-original-length");
  Admission admission = admit_request(std::move(head));
  if (auto* admitted = std::get_if<Admitted>(&admission)) admitted->asks_for_body = true;
  return admission;
}

RequestRouter::Admission RequestRouter::admit_request(Head head) const {
  Request request;
  static_cast<Head&>(request) = std::move(head);
  request.request_id = request_id_of(request);
  request.client = client_of(request);

  auto target = parse_target(request.target);
  if (!target) return refusal(target.error(), request);
  request.query = std::move(target->query);

  PathMatch match = match_routes(routes_, request.method, target->path);
  if (match.allowed.empty()) {
    return refusal({ProblemKind::kNotFound, "There is nothing at this URL.", {}, {}}, request);
  }
  request.parameters = std::move(match.parameters);
  if (!match.route && request.method == "OPTIONS") {
    match.allow("OPTIONS");
    Response response;
    response.status = 204;
    return finish(std::move(response).with("Allow", match.allowed), request);
  }
  if (!match.route) {
    return refusal({ProblemKind::kMethodNotAllowed, "Allowed here: " + match.allowed + ".", {}, {}},
                   request)
        .with("Allow", match.allowed);
  }
  if (const auto problem = problem_of_query(*match.route, request)) {
    return refusal(*problem, request);
  }
  if (const auto problem = problem_of_length(*match.route, request)) {
    return refusal(*problem, request);
  }
  return Admitted{match.route, std::move(request), false};
}

Outcome<void> RequestRouter::check_origin(const Request& request) const {
  const std::string_view origin = request.header("origin");
  if (is_safe(request.method) || origin.empty() || origin == options_.public_url) return {};
  return refuse(ProblemKind::kOrigin, "Requests from other origins are not allowed.");
}

Outcome<Principal> RequestRouter::identify_bearer(const Route& route, const Request& request,
                                                  Accounts::Renewal renewal) const {
  const std::string_view bearer = bearer_of(request);
  if (route.access == Access::kPersonOrOperator && !options_.sample_token.empty() &&
      equal_in_constant_time(bearer, options_.sample_token)) {
    Principal operator_of_sample;
    operator_of_sample.sample_operator = true;
    return operator_of_sample;
  }
  if (!options_.tokens) return refuse(ProblemKind::kUnauthenticated, "The token is not valid.");
  // No browser sends a token by itself, so a request with one needs no CSRF token.
  auto principal = options_.tokens->authenticate(bearer, route.operation, renewal);
  DIAPHANE_TRY(principal);
  if (needs_consent(route) && !principal->consented) return consent_needed();
  DIAPHANE_TRY(check_archive_access(route, *principal));
  return principal;
}

Outcome<Principal> RequestRouter::identify(const Route& route, const Request& request,
                                           Accounts::Renewal renewal) const {
  DIAPHANE_TRY(check_origin(request));
  if (route.access == Access::kAnyone || route.access == Access::kParticipant) return Principal{};

  if (!request.header("authorization").empty()) return identify_bearer(route, request, renewal);
  auto principal = accounts_.authenticate(token_of(request), renewal);
  if (!principal && route.access == Access::kAnyoneOrPerson &&
      principal.error().kind == ProblemKind::kUnauthenticated) {
    return Principal{};
  }
  if (!principal) return principal;
  if (!is_safe(request.method) &&
      !equal_in_constant_time(request.header("x-csrf-token"), principal->csrf_token)) {
    return refuse(ProblemKind::kCsrf,
                  "The X-CSRF-Token header is missing or incorrect. Reload the page.");
  }
  if (needs_consent(route) && !principal->consented) return consent_needed();
  if (route.access == Access::kAdministrator && principal->administrator_waits) {
    return refuse(
        ProblemKind::kSecondFactorRequired,
        "Set up two-factor authentication in your account to use administrator features.");
  }
  if (route.access == Access::kAdministrator && !principal->administrator) {
    return refuse(ProblemKind::kForbidden, "Only administrators can do this.");
  }
  if (route.access == Access::kResearcher && !principal->researcher) {
    return refuse(ProblemKind::kForbidden,
                  "Only researchers can do this. An administrator can give you the role.");
  }
  DIAPHANE_TRY(check_archive_access(route, *principal));
  return principal;
}

/// Does not renew the session, because the request itself follows, which sends the new cookie.
Outcome<Response> RequestRouter::decide_body(const Route& route, const Request& request) const {
  const auto principal = identify(route, request, Accounts::Renewal::kNo);
  DIAPHANE_TRY(principal);
  if (route.body_check) {
    DIAPHANE_TRY(route.body_check(request, *principal, announced_bytes(request)));
  }
  Response response;
  response.status = 204;
  if (principal->sample_operator) return std::move(response).with("X-Account", "operator");
  if (principal->user_id.empty()) return response;
  return std::move(response).with("X-Account", principal->user_id);
}

Response RequestRouter::serve(Admitted& admitted) const {
  const auto began = std::chrono::steady_clock::now();
  const Route& route = *admitted.route;
  const Request& request = admitted.request;
  const log::RequestScope scope(request.request_id);
  Response response;
  try {
    bool renewed = false, begun = false;
    const auto answer = [&]() -> Outcome<Response> {
      if (admitted.asks_for_body) return decide_body(route, request);
      auto principal = identify(route, request, Accounts::Renewal::kYes);
      DIAPHANE_TRY(principal);
      principal->language = preferred_language(request.header("accept-language"));
      principal->client = request.client;
      renewed = principal->renewed;
      begun = true;
      return route.handler(request, *principal);
    };
    auto outcome = answer();
    // Nothing was started, or the request only reads, so a retry is safe.
    if (!outcome && (!begun || is_safe(request.method)) &&
        outcome.error().kind == ProblemKind::kOutcomeUnknown) {
      outcome = refuse(ProblemKind::kUnavailable,
                       "The service is temporarily unavailable. Please try again in a moment.",
                       outcome.error().retry_after);
    }
    response =
        outcome ? *std::move(outcome) : problem_response(outcome.error(), request.request_id);
    if (renewed) response.with("Set-Cookie", cookie(token_of(request)));
    if (response.body.size() > kMaxResponseBytes) throw log::SafeError("response over 1 MB");
  } catch (const std::exception& thrown) {
    log::error("request failed",
               {{"operation", route.operation}, {"reason", log::describe(thrown)}});
    response = problem_response(from_error({ErrorCode::kInternal, {}, {}}), request.request_id);
  }
  response = finish(std::move(response), request);
  // The request itself follows, and is logged and measured then.
  if (admitted.asks_for_body && response.status == 204) return response;
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  const auto bytes = static_cast<std::int64_t>(request.body.size());
  log::info("request", {{"operation", route.operation},
                        {"status", response.status},
                        {"ms", seconds * 1000},
                        {"body_bytes", bytes}});
  options_.measure({route.operation, response.status, seconds, bytes});
  return response;
}

Response RequestRouter::refusal(const Problem& problem, const Request& request) const {
  Response response = finish(problem_response(problem, request.request_id), request);
  const log::RequestScope scope(request.request_id);
  log::info("request", {{"operation", "none"}, {"status", response.status}});
  options_.measure({"none", response.status, 0, 0});
  return response;
}

Response RequestRouter::finish(Response response, const Request& request) const {
  response.with("X-Request-Id", request.request_id);
  response.with("X-Content-Type-Options", "nosniff");
  if (request.target.starts_with("/v1/uploads")) response.with("Tus-Resumable", "1.0.0");
  const bool cached = std::any_of(response.headers.begin(), response.headers.end(),
                                  [](const auto& h) { return h.first == "Cache-Control"; });
  if (!cached) response.with("Cache-Control", "no-store");
  if (request.method == "HEAD") {
    response.body.clear();
    response.content_type.clear();
  }
  // A line break in a header would allow response splitting.
  std::erase_if(response.headers, [](const auto& header) {
    const bool bad = !is_header_text(header.first) || !is_header_text(header.second);
    if (bad) log::error("dropped an invalid response header", {{"header", header.first}});
    return bad;
  });
  return response;
}

std::string RequestRouter::cookie(const std::string& token) const {
  const auto age = token.empty() ? std::chrono::seconds(0) : accounts_.session_life();
  return set_cookie(cookie_name_, token, age);
}

std::string RequestRouter::browser_cookie(const std::string& known_browser) const {
  return set_cookie(browser_cookie_name_, known_browser, kBrowserKnown);
}

std::string RequestRouter::set_cookie(const std::string& name, const std::string& value,
                                      std::chrono::seconds age) const {
  return name + "=" + value + "; Path=/; Max-Age=" + std::to_string(age.count()) +
         "; HttpOnly; SameSite=Strict" + (secure_ ? "; Secure" : "");
}

std::string RequestRouter::token_of(const Head& head) const {
  return cookie_of(head, cookie_name_);
}

std::string RequestRouter::known_browser_of(const Head& head) const {
  return cookie_of(head, browser_cookie_name_);
}

std::string RequestRouter::cookie_of(const Head& head, std::string_view name) {
  std::string_view rest = head.header("cookie");
  while (!rest.empty()) {
    const std::size_t end = rest.find(';');
    std::string_view pair = rest.substr(0, end);
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
    while (pair.starts_with(' ')) pair.remove_prefix(1);
    if (pair.starts_with(name) && pair.substr(name.size()).starts_with('=')) {
      return std::string(pair.substr(name.size() + 1));
    }
  }
  return {};
}

Outcome<IdempotencyScope> idempotency_scope_of(const Request& request,
                                               const RequestRouter& router) {
  auto key = idempotency_key(request);
  DIAPHANE_TRY(key);
  const std::string_view bearer = bearer_of(request);
  return IdempotencyScope{*std::move(key),
                          bearer.empty() ? router.token_of(request) : std::string(bearer)};
}

}  // namespace diaphane::api
