#include "api/accounts/routes.h"
#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

constexpr std::size_t kMostVersionCharacters = 40;

Outcome<Response> me(Accounts& accounts, RenderTime& render_time, const Principal& who) {
  const auto quota = accounts.quota_of(who.user_id);
  DIAPHANE_TRY(quota);
  const auto time = render_time.account(who.user_id);
  DIAPHANE_TRY(time);
  const auto consent_at = accounts.consent_at(who);
  DIAPHANE_TRY(consent_at);
  nlohmann::ordered_json consent{{"version", accounts.consent_version()}, {"given_at", nullptr}};
  if (*consent_at) consent["given_at"] = rfc3339(**consent_at);
  nlohmann::ordered_json spent{{"quota_ms", time->quota_ms},
                               {"used_ms", time->used_ms},
                               {"renewed_at", rfc3339(time->next_month)},
                               {"pictures_end_at", nullptr}};
  if (time->spent() && time->warned_at) {
    spent["pictures_end_at"] = rfc3339(*time->warned_at + RenderTime::kGrace);
  }
  return json_response(200, {{"id", who.user_id},
                             {"email", who.email},
                             {"csrf_token", who.csrf_token},
                             {"administrator", who.administrator || who.administrator_waits},
                             {"researcher", who.researcher},
                             {"archive_access", who.archive_access},
                             {"second_factor", who.second_factor},
                             {"consent", std::move(consent)},
                             {"quota", {{"bytes", quota->bytes}, {"used_bytes", quota->used}}},
                             {"render_time", std::move(spent)}});
}

Outcome<Response> sign_up_with_consent(Accounts& accounts, const Request& request,
                                       const Principal& who) {
  Fields in(request);
  const std::string email = in.text("email", 3, 254);
  const bool consents = in.boolean("consent");
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto done = accounts.sign_up(email, consents ? Consent::kGiven : Consent::kMissing,
                                     who.client.address, who.language);
  DIAPHANE_TRY(done);
  return empty_response(202);
}

Outcome<Response> consent(Accounts& accounts, const Request& request, const Principal& who) {
  Fields in(request);
  const std::string version = in.text("version", 1, kMostVersionCharacters);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto done = accounts.give_consent(who, version);
  DIAPHANE_TRY(done);
  return empty_response(204);
}

/// Responds with the user and with the cookies for a browser that has just signed in.
Outcome<Response> signed_in(Accounts& accounts, RenderTime& render_time,
                            const RequestRouter& router, const Accounts::Opened& opened) {
  auto response = me(accounts, render_time, opened.principal);
  if (response) {
    response->with("Set-Cookie", router.cookie(opened.token));
    // The HTTP library would join two Set-Cookie headers into one, so the edge sends this one.
    response->with("X-Known-Browser", router.browser_cookie(opened.known_browser));
  }
  return response;
}

}  // namespace

std::vector<Route> account_routes(Accounts& accounts, RenderTime& render_time,
                                  const RequestRouter& router) {
  const auto sign_up = [&accounts](const Request& request, const Principal& who) {
    return sign_up_with_consent(accounts, request, who);
  };
  const auto verify = [&accounts, &render_time, &router](
                          const Request& request, const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string token = in.text("token", 1, 200);
    const std::string password = in.secret("password", kPasswordBytes);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto opened = accounts.verify(token, password, who.client.browser);
    DIAPHANE_TRY(opened);
    return signed_in(accounts, render_time, router, *opened);
  };
  const auto sign_in = [&accounts, &render_time, &router](
                           const Request& request, const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string email = in.text("email", 3, 254);
    const std::string password = in.secret("password", kPasswordBytes);
    const std::string code = in.text_or("code", "", kCodeCharacters);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto opened =
        accounts.sign_in(email, password, code, who.client.address, who.client.browser,
                         router.known_browser_of(request), who.language);
    DIAPHANE_TRY(opened);
    return signed_in(accounts, render_time, router, *opened);
  };
  const auto sign_out = [&accounts, &router](const Request& request,
                                             const Principal&) -> Outcome<Response> {
    const auto done = accounts.sign_out(router.token_of(request));
    DIAPHANE_TRY(done);
    return empty_response(204).with("Set-Cookie", router.cookie(""));
  };
  const auto give_consent = [&accounts](const Request& request, const Principal& who) {
    return consent(accounts, request, who);
  };
  const auto get_me = [&accounts, &render_time](const Request&, const Principal& who) {
    return me(accounts, render_time, who);
  };
  return {
      {"POST", "/v1/accounts", "signUp", Access::kAnyone, sign_up, {}},
      {"POST", "/v1/accounts/verify", "verifyAccount", Access::kAnyone, verify, {}},
      {"POST", "/v1/sign-in", "signIn", Access::kAnyone, sign_in, {}},
      {"POST", "/v1/sign-out", "signOut", Access::kOwnAccount, sign_out, {}},
      {"GET", "/v1/me", "getMe", Access::kOwnAccount, get_me, {}},
      {"POST", "/v1/me/consent", "giveConsent", Access::kOwnAccount, give_consent, {}},
  };
}

}  // namespace diaphane::api
