#include "api/routing/request_router.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "api/routing/request_fields.h"
#include "api/routing/target.h"
#include "api/shared/secrets.h"
#include "tests/support/api/fake_account_store.h"
#include "tests/support/api/fake_api_token_store.h"
#include "tests/support/api/fake_second_factor_store.h"

namespace diaphane::api {
namespace {

class RequestRouterTest : public testing::Test {
 protected:
  RequestRouterTest() {
    const auto answer = [this](const Request& request, const Principal& who) -> Outcome<Response> {
      ++served;
      asked_by = who;
      seen = request;
      if (request.body == "throw") throw std::runtime_error("a defect");
      if (request.body == "in doubt") {
        return refuse(Error{ErrorCode::kOutcomeUnknown, "It may or may not have been saved.", {}});
      }
      Response response;
      response.content_type = "text/plain";
      response.body = request.body == "large" ? std::string(2 << 20, 'x') : "well";
      return std::move(response).with("X-Said", request.body);
    };
    router.add({{"GET", "/v1/things/{id}", "getThing", Access::kPerson, answer, {"limit"}},
                {"POST", "/v1/things", "makeThing", Access::kPersonOrOperator, answer, {}},
                {"DELETE", "/v1/things/{id}", "deleteThing", Access::kPerson, answer, {}},
                {"POST", "/v1/me/things", "makeOwnThing", Access::kOwnAccount, answer, {}},
                {"GET", "/v1/data-sets", "listDataSets", Access::kPerson, answer, {}},
                {"POST", "/v1/data-sets", "createDataSet", Access::kPersonOrOperator, answer, {}},
                {"GET", "/v1/ruled", "rule", Access::kAdministrator, answer, {}},
                {"POST", "/v1/open", "open", Access::kAnyone, answer, {}, 100},
                {"POST", "/v1/plain", "plain", Access::kAnyone, answer, {}},
                {"PATCH",
                 "/v1/parts/{id}",
                 "append",
                 Access::kPersonOrOperator,
                 answer,
                 {},
                 8 << 20,
                 [this](const Request& request, const Principal&, std::int64_t bytes) {
                   checked = request.parameter("id") + " " + std::to_string(bytes);
                   return bytes > 1000 ? Outcome<void>(refuse(ProblemKind::kLocked, "Not now."))
                                       : Outcome<void>();
                 }}});
    WebSession session{blake2b(kToken), "user", kCsrf, clock.wall(),
                       clock.wall() + std::chrono::hours(24 * 14)};
    (void)store.open_session(session);
    store.consents["user"] = {kPrivacyTemplate, clock.wall()};
  }

  Response ask(Head head, std::string body = "") {
    auto admission = router.admit(std::move(head));
    if (auto* response = std::get_if<Response>(&admission)) return *response;
    auto& admitted = std::get<RequestRouter::Admitted>(admission);
    admitted.request.body = std::move(body);
    return router.serve(admitted);
  }
  /// Sends the query that the edge sends before it reads the body of such a request.
  Response ask_for_body(const Head& head, const std::string& length) {
    Head question{"GET", std::string(kBodyGate), head.headers};
    question.headers["x-original-method"] = head.method;
    question.headers["x-original-target"] = head.target;
    question.headers["x-original-length"] = length;
    return ask(std::move(question));
  }
  static std::string kind(const Response& response) {
    return nlohmann::json::parse(response.body)["type"].get<std::string>().substr(21);
  }
  static std::string header(const Response& response, const std::string& name) {
    for (const auto& [n, v] : response.headers) {
      if (n == name) return v;
    }
    return "";
  }

  const std::string kToken = std::string(64, 'a'), kCsrf = std::string(64, 'c');
  const std::string kCookie = "other=1; __Host-diaphane=" + kToken;
  FakeAccountStore store;
  ManualClock clock;
  Signals signals;
  FakePasswordHasher hasher;
  FakeSecondFactorStore factors;
  const SealingKey key = SealingKey::of_hex(std::string(64, '1')).value();
  CodeCheck codes{factors, store, key, clock, signals, {}};
  Accounts accounts{
      store, hasher, codes, key, clock, signals, {.public_url = "https://see.example"}};
  FakeApiTokenStore token_store;
  ApiTokens tokens{token_store, accounts, clock, signals, {}};
  RequestRouter router{
      accounts, {.public_url = "https://see.example", .sample_token = "s3cret", .tokens = &tokens}};
  int served = 0;
  std::string checked;
  Principal asked_by;
  Request seen;
};

TEST_F(RequestRouterTest, TakesLanguageFromRequestWithoutSession) {
  (void)ask({"POST", "/v1/open", {{"accept-language", "de-AT, en;q=0.5"}}});
  EXPECT_EQ(asked_by.language, Language::kGerman);
  (void)ask({"POST", "/v1/open", {{"accept-language", "fr"}}});
  EXPECT_EQ(asked_by.language, Language::kEnglish);
}

TEST_F(RequestRouterTest, TakesClientFromTheHeadersOfTheEdge) {
  (void)ask({"POST", "/v1/open", {}});
  EXPECT_EQ(asked_by.client.address, "local");
  EXPECT_EQ(asked_by.client.browser, "");
  const std::string browser = "Firefox on \x01Windows" + std::string(60, 'x');
  (void)ask({"POST", "/v1/open", {{"x-forwarded-for", "203.0.113.77"}, {"x-browser", browser}}});
  EXPECT_EQ(asked_by.client.address, "203.0.113.77");
  EXPECT_EQ(asked_by.client.browser, "Firefox on Windows" + std::string(41, 'x'));
}

TEST_F(RequestRouterTest, RequiresSessionCookie) {
  EXPECT_EQ(ask({"GET", "/v1/things/1", {}}).status, 401);
  EXPECT_EQ(
      ask({"GET", "/v1/things/1", {{"cookie", "__Host-diaphane=" + std::string(64, 'b')}}}).status,
      401);
  EXPECT_EQ(served, 0);
  EXPECT_EQ(ask({"GET", "/v1/things/1", {{"cookie", kCookie}}}).status, 200);
  EXPECT_EQ(asked_by.user_id, "user");
  EXPECT_EQ(seen.parameter("id"), "1");
}

TEST_F(RequestRouterTest, UnsafeMethodRequiresCsrfTokenOfItsSession) {
  EXPECT_EQ(kind(ask({"POST", "/v1/things", {{"cookie", kCookie}}})), "csrf");
  EXPECT_EQ(kind(ask({"POST", "/v1/things", {{"cookie", kCookie}, {"x-csrf-token", kToken}}})),
            "csrf");
  EXPECT_EQ(served, 0);
  EXPECT_EQ(ask({"POST", "/v1/things", {{"cookie", kCookie}, {"x-csrf-token", kCsrf}}}).status,
            200);
}

TEST_F(RequestRouterTest, ApiTokenReplacesTheCookieWithinItsScopes) {
  const std::string secret = std::string(kApiTokenPrefix) + std::string(64, 'd');
  const auto give = [&](std::vector<TokenScope> scopes) {
    token_store.tokens[blake2b(secret)] = {{"token", "Notebook", std::move(scopes), clock.wall(),
                                            clock.wall() + std::chrono::hours(1)},
                                           "user",
                                           "a@example.org",
                                           kPrivacyTemplate};
  };
  const std::map<std::string, std::string> with{{"authorization", "Bearer " + secret}};
  EXPECT_EQ(ask({"GET", "/v1/data-sets", with}).status, 401);
  give({TokenScope::kRead});
  EXPECT_EQ(ask({"GET", "/v1/data-sets", with}).status, 200);
  EXPECT_EQ(asked_by.user_id, "user");
  EXPECT_EQ(kind(ask({"POST", "/v1/data-sets", with})), "forbidden");
  EXPECT_EQ(kind(ask_for_body({"POST", "/v1/data-sets", with}, "5")), "forbidden");
  EXPECT_EQ(kind(ask({"GET", "/v1/things/1", with})), "forbidden") << "not in the list";
  EXPECT_EQ(kind(ask({"POST", "/v1/me/things", with})), "forbidden");
  give({TokenScope::kWrite});
  EXPECT_EQ(ask({"POST", "/v1/data-sets", with}).status, 200) << "needs no CSRF token";
  token_store.tokens.begin()->second.consent_version = "2020-01-01";
  EXPECT_EQ(kind(ask({"POST", "/v1/data-sets", with})), "consent-needed");
}

TEST_F(RequestRouterTest, AnInvalidApiTokenIsNotReplacedByTheCookie) {
  EXPECT_EQ(
      ask({"GET", "/v1/data-sets", {{"cookie", kCookie}, {"authorization", "Bearer x"}}}).status,
      401);
}

TEST_F(RequestRouterTest, DerivesSecretsFromTheApiToken) {
  Request request;
  request.headers = {{"authorization", "Bearer diaphane_a"}, {"idempotency-key", "k"}};
  EXPECT_EQ(idempotency_scope_of(request, router)->browser, "diaphane_a");
}

TEST_F(RequestRouterTest, WithoutConsentAPersonCanOnlyReadDeleteAndManageTheAccount) {
  store.consents["user"].first = "2020-01-01";
  const std::map<std::string, std::string> person{{"cookie", kCookie}, {"x-csrf-token", kCsrf}};
  EXPECT_EQ(kind(ask({"POST", "/v1/things", person})), "consent-needed");
  EXPECT_EQ(kind(ask_for_body({"PATCH", "/v1/parts/1", person}, "5")), "consent-needed");
  EXPECT_EQ(served, 0);
  EXPECT_EQ(ask({"GET", "/v1/things/1", person}).status, 200);
  EXPECT_EQ(ask({"DELETE", "/v1/things/1", person}).status, 200);
  EXPECT_EQ(ask({"POST", "/v1/me/things", person}).status, 200);
  store.consents["user"].first = kPrivacyTemplate;
  EXPECT_EQ(ask({"POST", "/v1/things", person}).status, 200);
}

TEST_F(RequestRouterTest, BodyGateReturnsAccountWithoutRunningHandler) {
  const Head made{"POST", "/v1/things", {{"cookie", kCookie}, {"x-csrf-token", kCsrf}}};
  const Response may = ask_for_body(made, "5000");
  EXPECT_EQ(may.status, 204);
  EXPECT_EQ(header(may, "X-Account"), "user");
  EXPECT_EQ(header(ask_for_body({"POST", "/v1/things", {{"authorization", "Bearer s3cret"}}}, "5"),
                   "X-Account"),
            "operator");
  const Response open = ask_for_body({"POST", "/v1/open", {}}, "5");
  EXPECT_EQ(open.status, 204);
  EXPECT_EQ(header(open, "X-Account"), "");
  EXPECT_EQ(served, 0);
}

TEST_F(RequestRouterTest, BodyGateReturnsTheRefusalOfTheRequest) {
  const std::map<std::string, std::string> person{{"cookie", kCookie}, {"x-csrf-token", kCsrf}};
  EXPECT_EQ(kind(ask_for_body({"POST", "/v1/things", {}}, "5")), "unauthenticated");
  EXPECT_EQ(kind(ask_for_body({"POST", "/v1/things", {{"cookie", kCookie}}}, "5")), "csrf");
  EXPECT_EQ(kind(ask_for_body({"POST", "/v1/open", {{"origin", "null"}}}, "5")), "origin");
  EXPECT_EQ(kind(ask_for_body({"POST", "/v1/none", person}, "5")), "not-found");
  EXPECT_EQ(kind(ask_for_body({"PATCH", "/v1/things", person}, "5")), "method-not-allowed");
  EXPECT_EQ(kind(ask_for_body({"POST", "/v1/things", person}, "1048577")), "body-too-large");
  EXPECT_EQ(kind(ask_for_body({"GET", std::string(kBodyGate), person}, "5")), "not-found");
  EXPECT_EQ(ask_for_body({"PATCH", "/v1/parts/7", person}, "1000").status, 204);
  EXPECT_EQ(checked, "7 1000");
  EXPECT_EQ(kind(ask_for_body({"PATCH", "/v1/parts/7", person}, "1001")), "locked");
  EXPECT_EQ(served, 0);
}

TEST_F(RequestRouterTest, LimitsBodySizeOfUnauthenticatedRequests) {
  const std::string most = std::to_string(kAnyoneBodyBytes);
  const std::string more = std::to_string(kAnyoneBodyBytes + 1);
  EXPECT_EQ(ask({"POST", "/v1/plain", {{"content-length", most}}}).status, 200);
  EXPECT_EQ(kind(ask({"POST", "/v1/plain", {{"content-length", more}}})), "body-too-large");
  EXPECT_EQ(kind(ask_for_body({"POST", "/v1/plain", {}}, more)), "body-too-large");
  EXPECT_EQ(kind(ask_for_body({"POST", "/v1/open", {}}, "101")), "body-too-large");
}

TEST_F(RequestRouterTest, BodyGateDoesNotRenewSession) {
  clock.advance(std::chrono::hours(24 * 7));
  const Head made{"POST", "/v1/things", {{"cookie", kCookie}, {"x-csrf-token", kCsrf}}};
  EXPECT_EQ(header(ask_for_body(made, "5"), "Set-Cookie"), "");
  EXPECT_THAT(header(ask(made), "Set-Cookie"), testing::HasSubstr(kToken));
}

TEST_F(RequestRouterTest, RefusesForeignOriginEvenOnPublicRoutes) {
  for (const char* origin :
       {"null", "https://see.example.evil", "http://see.example", "https://see.example:1"}) {
    EXPECT_EQ(kind(ask({"POST", "/v1/open", {{"origin", origin}}})), "origin") << origin;
  }
  EXPECT_EQ(ask({"POST", "/v1/open", {{"origin", "https://see.example"}}}).status, 200);
}

TEST_F(RequestRouterTest, SampleTokenWorksOnlyOnOperatorRoutes) {
  EXPECT_EQ(ask({"POST", "/v1/things", {{"authorization", "Bearer s3cret"}}}).status, 200);
  EXPECT_TRUE(asked_by.sample_operator);
  EXPECT_EQ(ask({"POST", "/v1/things", {{"authorization", "Bearer s3creT"}}}).status, 401);
  EXPECT_EQ(ask({"GET", "/v1/things/1", {{"authorization", "Bearer s3cret"}}}).status, 401);
  RequestRouter without(accounts, {.public_url = "https://see.example"});
  without.add({{"POST", "/v1/things", "makeThing", Access::kPersonOrOperator, {}, {}}});
  auto admitted = without.admit({"POST", "/v1/things", {{"authorization", "Bearer "}}});
  EXPECT_EQ(without.serve(std::get<RequestRouter::Admitted>(admitted)).status, 401);
}

TEST_F(RequestRouterTest, InternalErrorResponseHidesTheReason) {
  const Response response = ask({"POST", "/v1/open", {}}, "throw");
  EXPECT_EQ(response.status, 500);
  EXPECT_EQ(kind(response), "internal");
  EXPECT_EQ(response.body.find("defect"), std::string::npos);
}

TEST_F(RequestRouterTest, UnknownOutcomeOfWriteIsReportedAsUnknown) {
  const Response response = ask({"POST", "/v1/open", {}}, "in doubt");
  EXPECT_EQ(response.status, 503);
  EXPECT_EQ(kind(response), "outcome-unknown");
  EXPECT_EQ(header(response, "Retry-After"), "2");
}

TEST_F(RequestRouterTest, UnknownOutcomeOfReadIsReportedAsUnavailable) {
  const Response response = ask({"GET", "/v1/things/1", {{"cookie", kCookie}}}, "in doubt");
  EXPECT_EQ(response.status, 503);
  EXPECT_EQ(kind(response), "unavailable");
  EXPECT_EQ(header(response, "Retry-After"), "2");
}

TEST_F(RequestRouterTest, DropsResponseHeaderWithLineBreak) {
  const Response response = ask({"POST", "/v1/open", {}}, "a\r\nSet-Cookie: x=y");
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(header(response, "X-Said"), "");
}

TEST_F(RequestRouterTest, RefusesResponseOverOneMebibyte) {
  EXPECT_EQ(ask({"POST", "/v1/open", {}}, "large").status, 500);
}

TEST_F(RequestRouterTest, RefusesTooLargeOrInvalidContentLengthBeforeReadingBody) {
  EXPECT_EQ(ask({"POST", "/v1/open", {{"content-length", "101"}}}).status, 413);
  EXPECT_EQ(ask({"POST", "/v1/open", {{"content-length", "100"}}}).status, 200);
  for (const char* bad : {"-1", "1, 1", "0x10", "99999999999999999999"}) {
    EXPECT_EQ(ask({"POST", "/v1/open", {{"content-length", bad}}}).status, 400) << bad;
  }
  EXPECT_EQ(ask({"POST", "/v1/open", {{"transfer-encoding", "chunked"}}}).status, 400);
}

TEST_F(RequestRouterTest, AnswersHeadAndOptionsAndRefusesOtherMethods) {
  const Response wrong = ask({"DELETE", "/v1/open", {}});
  EXPECT_EQ(wrong.status, 405);
  EXPECT_EQ(header(wrong, "Allow"), "POST");
  const Response options = ask({"OPTIONS", "/v1/open", {}});
  EXPECT_EQ(options.status, 204);
  EXPECT_EQ(header(options, "Allow"), "POST, OPTIONS");
  const Response trace = ask({"TRACE", "/v1/open", {{"cookie", kCookie}}});
  EXPECT_EQ(trace.status, 405);
  EXPECT_EQ(trace.body.find(kToken), std::string::npos);
  const Response head = ask({"HEAD", "/v1/things/1", {{"cookie", kCookie}}});
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.body, "");
}

TEST_F(RequestRouterTest, KeepsWellFormedRequestIdAndReplacesOthers) {
  EXPECT_EQ(
      header(ask({"GET", "/v1/none", {{"x-request-id", "0123456789abcdef"}}}), "X-Request-Id"),
      "0123456789abcdef");
  const std::string made =
      header(ask({"GET", "/v1/none", {{"x-request-id", "a b\"c"}}}), "X-Request-Id");
  EXPECT_EQ(made.size(), 32u);
}

TEST_F(RequestRouterTest, SessionCookieHasSecurityAttributes) {
  const std::string cookie = router.cookie(kToken);
  for (const char* part : {"HttpOnly", "SameSite=Strict", "Secure", "Path=/"}) {
    EXPECT_THAT(cookie, testing::HasSubstr(part));
  }
  EXPECT_THAT(router.cookie(""), testing::HasSubstr("Max-Age=0"));
  EXPECT_THAT(cookie, testing::StartsWith("__Host-diaphane=" + kToken));
  EXPECT_THAT(cookie, testing::Not(testing::HasSubstr("Domain")));
}

TEST_F(RequestRouterTest, AcceptsOnlyHostPrefixedCookieUnderHttps) {
  EXPECT_EQ(ask({"GET", "/v1/things/1", {{"cookie", "diaphane=" + kToken}}}).status, 401);
  const RequestRouter plain(accounts, {.public_url = "http://see.example"});
  EXPECT_THAT(plain.cookie(kToken), testing::StartsWith("diaphane=" + kToken));
  EXPECT_EQ(plain.token_of({"GET", "/", {{"cookie", "diaphane=" + kToken}}}), kToken);
}

TEST_F(RequestRouterTest, AdministratorRoutesRequireSecondFactor) {
  const Head head{"GET", "/v1/ruled", {{"cookie", kCookie}}};
  EXPECT_EQ(kind(ask(head)), "forbidden");
  store.administrator = true;
  EXPECT_EQ(kind(ask(head)), "second-factor-required");
  EXPECT_EQ(ask({"GET", "/v1/things/1", {{"cookie", kCookie}}}).status, 200);
  EXPECT_FALSE(asked_by.administrator);
  store.second_factor = true;
  EXPECT_EQ(ask(head).status, 200);
  EXPECT_TRUE(asked_by.administrator);
}

TEST(Target, RefusesPathsThatAreNotInNormalForm) {
  for (const char* bad : {"", "v1", "//x/admin", "/v1//me", "/v1/../admin", "/v1/./me", "/v1/%6de",
                          "/v1/me%00", "/v1/m e", "*", "http://evil/v1/me", "/v1/me;x=1",
                          "/v1/\\me", "/v1/me?a=%", "/v1/me?a=%0a", "/v1/me?a=1&a=2"}) {
    EXPECT_FALSE(parse_target(bad)) << bad;
  }
  const auto target = parse_target("/v1/me?limit=5&cursor=a%2Eb+c&flag");
  ASSERT_TRUE(target);
  EXPECT_EQ(target->path, "/v1/me");
  EXPECT_EQ(target->query, (std::map<std::string, std::string>{
                               {"limit", "5"}, {"cursor", "a.b c"}, {"flag", ""}}));
}

TEST(Target, PatternMatchesWholeSegmentsOnly) {
  EXPECT_TRUE(match_path("/v1/a/{x}/b", "/v1/a/1/b"));
  for (const char* other : {"/v1/a//b", "/v1/a/1", "/v1/a/1/b/", "/v1/a/1/c", "/v1/a/1/2/b"}) {
    EXPECT_FALSE(match_path("/v1/a/{x}/b", other)) << other;
  }
}

TEST(RequestFields, ReportsAllInvalidFieldsTogether) {
  Request request;
  request.headers["content-type"] = "application/json; charset=utf-8";
  request.body = R"({"title": 5, "bytes": -1, "surprise": true})";
  Fields in(request);
  in.text_or("title", "", 80);
  in.integer("bytes", 1, 100);
  in.text("email", 3, 254);
  const auto wrong = in.finish();
  ASSERT_TRUE(wrong);
  std::vector<std::string> fields;
  for (const FieldProblem& field : wrong->fields) fields.push_back(field.field);
  EXPECT_THAT(fields, testing::UnorderedElementsAre("title", "bytes", "email", "surprise"));
}

}  // namespace
}  // namespace diaphane::api
