#include "api/accounts/routes.h"
#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/routing/route_parts.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

Outcome<Response> list_browsers(AccountChanges& changes, const Principal& who) {
  const auto found = changes.browser_sessions(who);
  DIAPHANE_TRY(found);
  nlohmann::ordered_json items = nlohmann::ordered_json::array();
  for (const BrowserSession& one : *found) {
    items.push_back({{"id", one.id},
                     {"browser", one.browser},
                     {"current", one.id == who.session_id},
                     {"created_at", rfc3339(one.created_at)},
                     {"used_at", rfc3339(one.used_at)}});
  }
  return json_response(200, {{"items", std::move(items)}});
}

std::vector<Route> password_routes(AccountChanges& changes) {
  const auto request_reset = [&changes](const Request& request,
                                        const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string email = in.text("email", 3, 254);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    return answer(changes.request_reset(email, who.client.address, who.language), 202);
  };
  const auto reset = [&changes](const Request& request, const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string token = in.text("token", 1, 200);
    const std::string password = in.secret("password", kPasswordBytes);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    return answer(changes.reset(token, password, who.language));
  };
  const auto change_password = [&changes](const Request& request,
                                          const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string current = in.secret("current", kPasswordBytes);
    const std::string password = in.secret("password", kPasswordBytes);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    return answer(changes.change_password(who, current, password));
  };
  return {
      {"POST", "/v1/password-reset", "requestPasswordReset", Access::kAnyone, request_reset, {}},
      {"POST", "/v1/password-reset/confirm", "resetPassword", Access::kAnyone, reset, {}},
      {"POST", "/v1/me/password", "changePassword", Access::kOwnAccount, change_password, {}},
  };
}

std::vector<Route> email_routes(AccountChanges& changes) {
  const auto request_email = [&changes](const Request& request,
                                        const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string email = in.text("email", 3, 254);
    const std::string password = in.secret("password", kPasswordBytes);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    return answer(changes.request_email(who, email, password), 202);
  };
  const auto confirm_email = [&changes](const Request& request,
                                        const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string token = in.text("token", 1, 200);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    return answer(changes.confirm_email(who, token));
  };
  constexpr auto kOwn = Access::kOwnAccount;
  return {
      {"POST", "/v1/me/email", "requestEmailChange", kOwn, request_email, {}},
      {"POST", "/v1/email-change/confirm", "confirmEmailChange", kOwn, confirm_email, {}},
  };
}

std::vector<Route> browser_session_routes(AccountChanges& changes, const RequestRouter& router) {
  const auto browsers = [&changes](const Request&, const Principal& who) {
    return list_browsers(changes, who);
  };
  const auto end_one = [&changes](const Request& request,
                                  const Principal& who) -> Outcome<Response> {
    return answer(changes.end_browser_session(who, request.parameter("browser_session_id")));
  };
  const auto end_all = [&changes, &router](const Request&,
                                           const Principal& who) -> Outcome<Response> {
    const auto done = changes.sign_out_everywhere(who);
    DIAPHANE_TRY(done);
    return empty_response(204).with("Set-Cookie", router.cookie(""));
  };
  const std::string all = "/v1/me/browser-sessions";
  constexpr auto kOwn = Access::kOwnAccount;
  return {
      {"GET", all, "listBrowserSessions", kOwn, browsers, {}},
      {"DELETE", all, "signOutEverywhere", kOwn, end_all, {}},
      {"DELETE", all + "/{browser_session_id}", "endBrowserSession", kOwn, end_one, {}},
  };
}

}  // namespace

std::vector<Route> account_change_routes(AccountChanges& changes, const RequestRouter& router) {
  return join(
      {password_routes(changes), email_routes(changes), browser_session_routes(changes, router)});
}

}  // namespace diaphane::api
