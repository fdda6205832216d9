#include "api/accounts/api_tokens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/api/fake_account_store.h"
#include "tests/support/api/fake_api_token_store.h"
#include "tests/support/api/fake_second_factor_store.h"
#include "tests/support/api/refusals.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;
using enum TokenScope;
using testing::ElementsAre;
using testing::HasSubstr;
using Renewal = Accounts::Renewal;

const std::string kEmail = "person@example.org";
const std::string kPassword = "a long and quiet password";

class ApiTokensTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(accounts.sign_up(kEmail, Consent::kGiven, "1.2.3.4"));
    const std::string& body = store.mails.back().body;
    ASSERT_TRUE(accounts.verify(body.substr(body.find("#token=") + 7, 64), kPassword));
    who.user_id = store.accounts.begin()->second.id;
    who.email = kEmail;
  }
  ApiTokens::Request wanted(std::vector<TokenScope> scopes = {kRead}) const {
    return {"Notebook", std::move(scopes), 30, kPassword, ""};
  }
  ApiTokens::Created made(std::vector<TokenScope> scopes = {kRead}) {
    return tokens.create(who, wanted(std::move(scopes))).value();
  }
  Refusal refused(const std::string& secret, std::string_view operation) {
    return refusal(tokens.authenticate(secret, operation, Renewal::kYes));
  }

  FakeAccountStore store;
  FakeApiTokenStore token_store;
  ManualClock clock;
  Signals signals;
  FakePasswordHasher hasher;
  FakeSecondFactorStore factors;
  const SealingKey key = SealingKey::of_hex(std::string(64, '1')).value();
  CodeCheck codes{factors, store, key, clock, signals, {}};
  Accounts accounts{store, hasher, codes, key, clock, signals, {}};
  ApiTokens tokens{token_store, accounts, clock, signals, {"https://see.example/account"}};
  Principal who;
};

TEST_F(ApiTokensTest, OnlyItsHashIsStored) {
  const auto created = made();
  EXPECT_THAT(created.secret, testing::MatchesRegex("diaphane_[0-9a-f]{64}"));
  ASSERT_EQ(token_store.tokens.size(), 1u);
  const std::string& stored = token_store.tokens.begin()->first;
  EXPECT_EQ(created.secret.find(stored), std::string::npos);
  EXPECT_EQ(refused(std::string(kApiTokenPrefix) + stored, "listDataSets"),
            ProblemKind::kUnauthenticated);
  EXPECT_THAT(token_store.mails.back().body, HasSubstr("Notebook"));
  EXPECT_THAT(token_store.mails.back().body, Not(HasSubstr(created.secret)));
}

TEST_F(ApiTokensTest, ActsForItsUserWithoutTheRoleOfAnAdministrator) {
  const auto created = made();
  const auto principal = tokens.authenticate(created.secret, "listDataSets", Renewal::kYes);
  ASSERT_TRUE(principal);
  EXPECT_EQ(principal->user_id, who.user_id);
  EXPECT_EQ(principal->session_id, created.token.id) << "so that its streams end with it";
  EXPECT_TRUE(principal->consented);
  EXPECT_FALSE(principal->administrator || principal->administrator_waits);
  token_store.tokens.begin()->second.consent_version = "2020-01-01";
  EXPECT_FALSE(tokens.authenticate(created.secret, "listDataSets", Renewal::kYes)->consented);
}

TEST_F(ApiTokensTest, PermitsOnlyOperationsOfItsScopes) {
  const std::map<TokenScope, std::string_view> examples{{kRead, "createSession"},
                                                        {kWrite, "deleteDataSet"},
                                                        {kShare, "shareWithPerson"},
                                                        {kArchive, "searchArchive"}};
  for (const TokenScope scope : kTokenScopes) {
    const auto created = made({scope});
    for (const auto& [needed, operation] : examples) {
      EXPECT_EQ(refused(created.secret, operation),
                scope == needed ? Refusal() : ProblemKind::kForbidden)
          << to_string(scope) << " " << operation;
    }
  }
}

TEST_F(ApiTokensTest, ATokenOfAFetchOnlyUploadsWhileItsUserHasAccessToTheArchives) {
  const auto created = made({kWrite});
  TokenUse& use = token_store.tokens.begin()->second;
  use.for_fetch = true;
  EXPECT_EQ(refused(created.secret, "createDataSet"), ProblemKind::kUnauthenticated);
  use.archive_access = true;
  EXPECT_EQ(refused(created.secret, "createDataSet"), Refusal());
  EXPECT_EQ(refused(created.secret, "appendToUpload"), Refusal());
  EXPECT_EQ(refused(created.secret, "deleteDataSet"), ProblemKind::kForbidden);
}

TEST_F(ApiTokensTest, NeverReachesTheSecurityOfTheAccountOrTheAdministration) {
  const auto created = made({kRead, kWrite, kShare, kArchive});
  for (const char* operation :
       {"getMe", "changePassword", "requestEmailChange", "beginSecondFactor", "removeSecondFactor",
        "deleteAccount", "listApiTokens", "createApiToken", "revokeApiToken", "requestExport",
        "downloadExport", "listBrowserSessions", "listUsers", "changeUser", "listAudit",
        "takeDownDataSet", "anOperationOfTheFuture"}) {
    EXPECT_EQ(refused(created.secret, operation), ProblemKind::kForbidden) << operation;
  }
}

TEST_F(ApiTokensTest, IsNotCreatedOnceANewPasswordHasEndedTheSession) {
  token_store.ended_sessions.insert(who.session_id);
  EXPECT_EQ(refusal(tokens.create(who, wanted({kRead}))), ProblemKind::kUnauthenticated);
  EXPECT_TRUE(token_store.tokens.empty());
}

TEST_F(ApiTokensTest, ExpiresAndCanBeRevoked) {
  const auto first = made();
  const auto second = made();
  Principal other;
  other.user_id = "another";
  EXPECT_EQ(refusal(tokens.revoke(other, first.token.id)), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(tokens.revoke(who, "no ID")), ProblemKind::kNotFound);
  int ended = 0;
  signals.subscribe(Signal::kSignOut, [&] { ++ended; });
  EXPECT_TRUE(tokens.revoke(who, first.token.id));
  EXPECT_EQ(ended, 1) << "its streams end";
  EXPECT_EQ(refused(first.secret, "listDataSets"), ProblemKind::kUnauthenticated);
  EXPECT_EQ(refused(second.secret, "listDataSets"), Refusal());
  EXPECT_EQ(tokens.list(who)->size(), 1u);
  clock.advance(30 * 24h);
  EXPECT_EQ(refused(second.secret, "listDataSets"), ProblemKind::kUnauthenticated);
  EXPECT_TRUE(tokens.list(who)->empty());
}

TEST_F(ApiTokensTest, RecordsItsUseEveryTenMinutes) {
  const auto created = made();
  EXPECT_FALSE(tokens.list(who)->front().used_at);
  (void)tokens.authenticate(created.secret, "listDataSets", Renewal::kNo);
  EXPECT_EQ(refused(created.secret, "deleteDataSet"), ProblemKind::kForbidden);
  EXPECT_EQ(token_store.calls("touch"), 0);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(refused(created.secret, "listDataSets"), Refusal());
  EXPECT_EQ(token_store.calls("touch"), 1);
  EXPECT_EQ(tokens.list(who)->front().used_at, clock.wall());
  clock.advance(11min);
  EXPECT_EQ(refused(created.secret, "listDataSets"), Refusal());
  EXPECT_EQ(token_store.calls("touch"), 2);
}

TEST_F(ApiTokensTest, CreationRequiresThePasswordAndTheSecondFactor) {
  ApiTokens::Request request = wanted();
  request.password = "wrong wrong";
  EXPECT_EQ(invalid_field(tokens.create(who, request)), "password");
  for (int i = 0; i < 9; ++i) (void)tokens.create(who, request);
  EXPECT_EQ(refusal(tokens.create(who, wanted())), ProblemKind::kTooManyAttempts);
  clock.advance(15min);
  factors.factors[who.user_id] = {"", clock.wall(), clock.wall(), 0, 0};
  EXPECT_EQ(refusal(tokens.create(who, wanted())), ProblemKind::kCodeNeeded);
  EXPECT_TRUE(token_store.tokens.empty());
}

TEST_F(ApiTokensTest, AnAccountHasAtMostTwentyTokens) {
  for (int i = 0; i < ApiTokens::kMostTokens; ++i) made();
  EXPECT_EQ(refusal(tokens.create(who, wanted())), ProblemKind::kConflict);
}

TEST_F(ApiTokensTest, RefusesMalformedTokensWithoutAskingTheStore) {
  for (const std::string& bad :
       {std::string(), std::string(64, 'a'), "diaphane_" + std::string(63, 'a'),
        "diaphane_" + std::string(64, 'A'), "Diaphane_" + std::string(64, 'a')}) {
    EXPECT_EQ(refused(bad, "listDataSets"), ProblemKind::kUnauthenticated) << bad;
  }
  EXPECT_EQ(token_store.calls("find"), 0);
}

TEST_F(ApiTokensTest, EachStepThatFailsIsReportedAsUnavailable) {
  const auto created = made();
  expect_unavailable({
      {token_store, "create", [&] { return refusal(tokens.create(who, wanted())); }},
      {token_store, "list", [&] { return refusal(tokens.list(who)); }},
      {token_store, "revoke", [&] { return refusal(tokens.revoke(who, created.token.id)); }},
      {token_store, "find", [&] { return refused(created.secret, "listDataSets"); }},
      {token_store, "touch", [&] { return refused(created.secret, "listDataSets"); }},
  });
}

TEST(TokenScopes, AreStoredInOneOrder) {
  EXPECT_EQ(join_scopes({kShare, kRead}), "read share");
  EXPECT_THAT(split_scopes("read share"), ElementsAre(kRead, kShare));
  EXPECT_THAT(split_scopes(""), ElementsAre());
  EXPECT_EQ(token_scope_of("admin"), std::nullopt);
}

}  // namespace
}  // namespace diaphane::api
