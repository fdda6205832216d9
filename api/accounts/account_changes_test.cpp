#include "api/accounts/account_changes.h"

#include <gmock/gmock.h>

#include "tests/support/api/account_fixture.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Tokens in memory, and what was last changed of the account.
class FakeAccountChangeStore final : public AccountChangeStore, public Fake {
 public:
  struct Token {
    std::string purpose;
    TokenBearer bearer;
    Time expires_at;
  };
  std::map<std::string, Token> tokens;  ///< by hash
  TokenBearer account;                  ///< of `request_reset`, if the address has one
  bool is_disabled = false;
  std::vector<Mail> mails;
  EmailRequest email_request;
  std::string password_hash, kept_session, new_email_key;
  bool address_was_taken = false;
  std::vector<ExpiredBrowser> expired;
  std::vector<std::string> ended;

  Result<void> request_reset(const std::string& key, const std::string& token_hash, Time expires_at,
                             const ResetMails& possible) override {
    DIAPHANE_TRY(enter("request_reset"));
    if (key != email_key(account.email)) {
      mails.push_back(possible.unknown);
    } else if (is_disabled) {
      mails.push_back(possible.disabled);
    } else {
      tokens[token_hash] = {"reset", account, expires_at};
      mails.push_back(possible.reset);
    }
    return {};
  }
  Result<std::optional<TokenBearer>> find_token(const std::string& hash, const std::string& purpose,
                                                Time now) override {
    DIAPHANE_TRY(enter("find_token"));
    const auto found = tokens.find(hash);
    if (found == tokens.end() || found->second.purpose != purpose ||
        found->second.expires_at <= now) {
      return std::nullopt;
    }
    return found->second.bearer;
  }
  Result<bool> reset(const std::string& token_hash, const std::string& hash,
                     const Mail& notification, Time) override {
    DIAPHANE_TRY(enter("reset"));
    if (tokens.erase(token_hash) == 0) return false;
    password_hash = hash;
    mails.push_back(notification);
    return true;
  }
  Result<void> change_password(const std::string&, const std::string& hash, const std::string& kept,
                               const Mail& notification, Time) override {
    DIAPHANE_TRY(enter("change_password"));
    password_hash = hash;
    kept_session = kept;
    mails.push_back(notification);
    return {};
  }
  Result<void> request_email(const EmailRequest& request, Time) override {
    DIAPHANE_TRY(enter("request_email"));
    email_request = request;
    tokens[request.token_hash] = {
        "change", {request.user_id, account.email, request.new_email}, request.token_expires_at};
    return {};
  }
  Result<bool> confirm_email(const std::string& token_hash, const std::string& key,
                             const Mail& to_old, Time) override {
    DIAPHANE_TRY(enter("confirm_email"));
    if (address_was_taken || tokens.erase(token_hash) == 0) return false;
    new_email_key = key;
    mails.push_back(to_old);
    return true;
  }
  Result<std::vector<BrowserSession>> browser_sessions(const std::string& user_id, Time) override {
    DIAPHANE_TRY(enter("browser_sessions"));
    return std::vector<BrowserSession>{{"of " + user_id, "Firefox on Windows", {}, {}}};
  }
  Result<bool> end_browser_session(const std::string& user_id, const std::string& id) override {
    DIAPHANE_TRY(enter("end_browser_session"));
    if (user_id != account.user_id) return false;
    expired.push_back({id, user_id});
    return true;
  }
  Result<void> end_browser_sessions(const std::string& user_id, Time) override {
    DIAPHANE_TRY(enter("end_browser_sessions"));
    ended.push_back(user_id);
    return {};
  }
  Result<std::vector<ExpiredBrowser>> expired_browsers(Time, int) override {
    DIAPHANE_TRY(enter("expired_browsers"));
    return expired;
  }
  Result<void> forget_browser(const std::string& id) override {
    DIAPHANE_TRY(enter("forget_browser"));
    std::erase_if(expired, [&](const ExpiredBrowser& one) { return one.id == id; });
    return {};
  }
};

class AccountChangesTest : public AccountFixture {
 protected:
  AccountChangesTest() {
    store.account = {who.user_id, who.email, ""};
    signals.subscribe(Signal::kMail, [this] { ++woken; });
  }
  static std::string token_in(const Mail& mail) {
    return mail.body.substr(mail.body.find("#token=") + 7, 64);
  }
  /// Requests a reset of the password and returns the token in the email.
  std::string reset_token() {
    EXPECT_TRUE(changes.request_reset(who.email, "1.2.3.4"));
    return token_in(store.mails.back());
  }
  /// Requests a change of the address and returns the token in the email to the new one.
  std::string change_token(const std::string& new_email = "new@example.org") {
    EXPECT_TRUE(changes.request_email(who, new_email, password));
    return token_in(store.email_request.confirm);
  }

  const std::string new_password = "another quiet password";
  FakeAccountChangeStore store;
  int woken = 0;
  AccountChanges changes{store,     attempts, accounts, hasher,
                         placement, clock,    signals,  {.public_url = "https://see.example"}};
};

TEST_F(AccountChangesTest, AResetIsAnsweredTheSameWhetherOrNotTheAccountExists) {
  ASSERT_TRUE(changes.request_reset("ANNA@example.org", "1.2.3.4"));
  ASSERT_TRUE(changes.request_reset("nobody@example.org", "1.2.3.4"));
  EXPECT_EQ(woken, 2);
  ASSERT_EQ(store.mails.size(), 2u);
  EXPECT_THAT(store.mails[0].body, HasSubstr("https://see.example/reset#token="));
  EXPECT_EQ(store.mails[0].recipient, "ANNA@example.org");
  EXPECT_THAT(store.mails[1].body, HasSubstr("https://see.example/sign-up"));
  ASSERT_EQ(store.tokens.size(), 1u);
  EXPECT_EQ(store.tokens.begin()->first, blake2b(token_in(store.mails[0])))
      << "nothing that is stored resets a password";
}

TEST_F(AccountChangesTest, AResetOfADisabledAccountSaysSoAndHasNoLink) {
  store.is_disabled = true;
  ASSERT_TRUE(changes.request_reset(who.email, "1.2.3.4"));
  ASSERT_EQ(store.mails.size(), 1u);
  EXPECT_THAT(store.mails[0].body, HasSubstr("https://see.example/contact"));
  EXPECT_THAT(store.mails[0].body, Not(HasSubstr("#token=")));
  EXPECT_THAT(store.tokens, IsEmpty());
}

TEST_F(AccountChangesTest, AResetNeedsAnAddress) {
  EXPECT_EQ(invalid_field(changes.request_reset("anna", "1.2.3.4")), "email");
  EXPECT_THAT(store.mails, IsEmpty());
  EXPECT_EQ(attempts.calls("note_attempt"), 0);
}

TEST_F(AccountChangesTest, LimitsResetsPerMailboxToFourPerQuarterHourSilently) {
  for (int i = 0; i < 6; ++i) EXPECT_TRUE(changes.request_reset(who.email, std::to_string(i)));
  EXPECT_EQ(store.mails.size(), 4u);
  EXPECT_TRUE(changes.request_reset("ANNA@EXAMPLE.ORG", "another"));
  EXPECT_EQ(store.mails.size(), 4u) << "the address is the same in whatever case";
  EXPECT_EQ(woken, 4);
  clock.advance(15min);
  EXPECT_TRUE(changes.request_reset(who.email, "1.2.3.4"));
  EXPECT_EQ(store.mails.size(), 5u);
}

TEST_F(AccountChangesTest, LimitsResetsPerPeerToThirtyPerQuarterHour) {
  const auto request = [&](int i, const std::string& peer) {
    return changes.request_reset(std::to_string(i) + "@example.org", peer);
  };
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(request(i, "1.2.3.4"));
  EXPECT_EQ(refusal(request(30, "1.2.3.4")), ProblemKind::kTooManyAttempts);
  EXPECT_TRUE(request(30, "5.6.7.8"));
  clock.advance(15min);
  EXPECT_TRUE(request(31, "1.2.3.4"));
}

TEST_F(AccountChangesTest, AResetChangesThePasswordOnceAndEndsEverySession) {
  const std::string token = reset_token();
  ASSERT_TRUE(changes.reset(token, new_password));
  EXPECT_TRUE(hasher.verify(new_password, store.password_hash).value());
  EXPECT_EQ(store.mails.back().recipient, who.email);
  EXPECT_THAT(store.mails.back().body, HasSubstr("https://see.example/forgot"));
  EXPECT_EQ(woken, 2);
  EXPECT_THAT(placement.ended, ElementsAre("by " + who.user_id));
  EXPECT_EQ(refusal(changes.reset(token, new_password)), ProblemKind::kLinkExpired);
}

TEST_F(AccountChangesTest, ALinkToResetExpiresAfterAnHour) {
  const std::string token = reset_token();
  clock.advance(1h - 1s);
  EXPECT_EQ(invalid_field(changes.reset(token, "short")), "password") << "it is still valid";
  clock.advance(1s);
  EXPECT_EQ(refusal(changes.reset(token, new_password)), ProblemKind::kLinkExpired);
  EXPECT_EQ(store.password_hash, "");
}

TEST_F(AccountChangesTest, WeakPasswordDoesNotUseUpTheLink) {
  const std::string token = reset_token();
  EXPECT_EQ(invalid_field(changes.reset(token, "short")), "password");
  EXPECT_EQ(invalid_field(changes.reset(token, who.email)), "password");
  EXPECT_THAT(placement.ended, IsEmpty());
  EXPECT_TRUE(changes.reset(token, new_password));
}

TEST_F(AccountChangesTest, OnlyALinkThatWasMailedForItResetsAPassword) {
  EXPECT_EQ(invalid_field(changes.reset("no token", new_password)), "token");
  EXPECT_EQ(refusal(changes.reset(random_hex(32), new_password)), ProblemKind::kLinkExpired);
  EXPECT_EQ(refusal(changes.reset(change_token(), new_password)), ProblemKind::kLinkExpired);
  EXPECT_EQ(store.calls("reset"), 0);
}

TEST_F(AccountChangesTest, SecondOfTwoConcurrentResetsEndsNoSession) {
  const std::string token = reset_token();
  store.before("reset", [&] { store.tokens.clear(); });
  EXPECT_EQ(refusal(changes.reset(token, new_password)), ProblemKind::kLinkExpired);
  EXPECT_THAT(placement.ended, IsEmpty());
}

TEST_F(AccountChangesTest, ResetWorksDespiteGuessesOfOthers) {
  for (int i = 0; i < 10; ++i) {
    (void)accounts.sign_in(who.email, "wrong wrong", "", std::to_string(i));
  }
  EXPECT_EQ(counted("account", "anna@example.org"), 10);
  ASSERT_TRUE(changes.reset(reset_token(), new_password));
  EXPECT_EQ(counted("account", "anna@example.org"), 0);
}

TEST_F(AccountChangesTest, ChangingThePasswordNeedsTheOldOneAndKeepsOnlyThisBrowser) {
  EXPECT_EQ(invalid_field(changes.change_password(who, "wrong wrong", new_password)), "current");
  EXPECT_EQ(invalid_field(changes.change_password(who, password, "short")), "password");
  EXPECT_EQ(invalid_field(changes.change_password(who, password, who.email)), "password");
  EXPECT_EQ(store.password_hash, "");
  EXPECT_THAT(placement.ended, IsEmpty());
  ASSERT_TRUE(changes.change_password(who, password, new_password));
  EXPECT_TRUE(hasher.verify(new_password, store.password_hash).value());
  EXPECT_EQ(store.kept_session, who.session_id);
  EXPECT_EQ(store.mails.back().recipient, who.email);
  EXPECT_THAT(placement.ended, ElementsAre("by " + who.user_id));
  EXPECT_EQ(woken, 1);
}

TEST_F(AccountChangesTest, APasswordIsChangedEvenIfSessionsCannotBeEnded) {
  placement.away = true;
  EXPECT_TRUE(changes.change_password(who, password, new_password));
  EXPECT_TRUE(changes.reset(reset_token(), new_password));
  EXPECT_TRUE(changes.sign_out_everywhere(who));
}

TEST_F(AccountChangesTest, NotifiesBothAddressesOfARequestedChange) {
  ASSERT_TRUE(changes.request_email(who, "New@example.org", password));
  const EmailRequest& request = store.email_request;
  EXPECT_EQ(request.user_id, who.user_id);
  EXPECT_EQ(request.new_email, "New@example.org");
  EXPECT_EQ(request.new_email_key, "new@example.org");
  EXPECT_EQ(request.token_expires_at, clock.wall() + 48h);
  EXPECT_EQ(request.confirm.recipient, "New@example.org");
  EXPECT_THAT(request.confirm.body, HasSubstr("https://see.example/confirm-email#token="));
  EXPECT_EQ(request.token_hash, blake2b(token_in(request.confirm)));
  EXPECT_EQ(request.taken.recipient, "New@example.org");
  EXPECT_THAT(request.taken.body, testing::Not(HasSubstr("#token=")));
  EXPECT_EQ(request.to_old.recipient, who.email);
  EXPECT_EQ(woken, 1);
}

TEST_F(AccountChangesTest, AChangeOfTheAddressNeedsANewOneAndThePassword) {
  EXPECT_EQ(invalid_field(changes.request_email(who, "new", password)), "email");
  EXPECT_EQ(invalid_field(changes.request_email(who, "ANNA@example.org", password)), "email");
  EXPECT_EQ(invalid_field(changes.request_email(who, "new@example.org", "wrong")), "password");
  EXPECT_EQ(store.calls("request_email"), 0);
}

TEST_F(AccountChangesTest, LimitsAddressChangesPerUserToFourPerQuarterHour) {
  for (int i = 0; i < 4; ++i) change_token(std::to_string(i) + "@example.org");
  EXPECT_EQ(refusal(changes.request_email(who, "4@example.org", password)),
            ProblemKind::kTooManyAttempts);
  clock.advance(15min);
  change_token("4@example.org");
}

TEST_F(AccountChangesTest, LimitsAddressChangesPerMailboxToFourPerQuarterHour) {
  for (int i = 0; i < 4; ++i) {
    change_token();
    attempts.forget_attempts(attempt_key("change", who.user_id), std::nullopt);
  }
  EXPECT_EQ(refusal(changes.request_email(who, "NEW@example.org", password)),
            ProblemKind::kTooManyAttempts);
}

TEST_F(AccountChangesTest, TheNewAddressIsConfirmedOnceByTheAccountThatRequestedIt) {
  const std::string token = change_token("New@example.org");
  Principal other;
  other.user_id = new_id();
  EXPECT_EQ(refusal(changes.confirm_email(other, token)), ProblemKind::kForbidden);
  EXPECT_EQ(store.new_email_key, "");
  ASSERT_TRUE(changes.confirm_email(who, token));
  EXPECT_EQ(store.new_email_key, "new@example.org");
  EXPECT_EQ(store.mails.back().recipient, who.email) << "the old address is told";
  EXPECT_EQ(woken, 2);
  EXPECT_EQ(refusal(changes.confirm_email(who, token)), ProblemKind::kLinkExpired);
}

TEST_F(AccountChangesTest, ALinkToConfirmAnAddressExpiresAfterTwoDays) {
  const std::string early = change_token(), late = change_token();
  clock.advance(48h - 1s);
  EXPECT_TRUE(changes.confirm_email(who, early));
  clock.advance(1s);
  EXPECT_EQ(refusal(changes.confirm_email(who, late)), ProblemKind::kLinkExpired);
}

TEST_F(AccountChangesTest, OnlyALinkThatWasMailedForItConfirmsAnAddress) {
  EXPECT_EQ(invalid_field(changes.confirm_email(who, "no token")), "token");
  EXPECT_EQ(refusal(changes.confirm_email(who, random_hex(32))), ProblemKind::kLinkExpired);
  EXPECT_EQ(refusal(changes.confirm_email(who, reset_token())), ProblemKind::kLinkExpired);
  EXPECT_EQ(store.calls("confirm_email"), 0);
}

TEST_F(AccountChangesTest, AnAddressThatWasTakenMeanwhileIsNotConfirmed) {
  const std::string token = change_token();
  store.address_was_taken = true;
  EXPECT_EQ(refusal(changes.confirm_email(who, token)), ProblemKind::kLinkExpired);
  EXPECT_EQ(woken, 1);
}

TEST_F(AccountChangesTest, AUserSeesAndEndsTheirOwnBrowsers) {
  EXPECT_EQ(changes.browser_sessions(who)->at(0).id, "of " + who.user_id);
  EXPECT_EQ(refusal(changes.end_browser_session(who, "no id")), ProblemKind::kNotFound);
  EXPECT_EQ(store.calls("end_browser_session"), 0);
  Principal other;
  other.user_id = new_id();
  const std::string browser = new_id();
  EXPECT_EQ(refusal(changes.end_browser_session(other, browser)), ProblemKind::kNotFound);
  EXPECT_THAT(placement.ended, IsEmpty());
  ASSERT_TRUE(changes.end_browser_session(who, browser));
  EXPECT_THAT(placement.ended, ElementsAre("from " + browser + " of " + who.user_id))
      << "its streams end at once";
  EXPECT_THAT(store.expired, IsEmpty());
}

TEST_F(AccountChangesTest, AnExpiredBrowserIsForgottenOnlyOnceItsStreamsHaveEnded) {
  store.expired = {{"one", "anna"}, {"two", "bert"}};
  placement.break_function("end_all_from");
  changes.end_expired_browsers();
  EXPECT_EQ(store.expired.size(), 2u);
  placement.repair("end_all_from");
  store.break_function("expired_browsers");
  changes.end_expired_browsers();
  EXPECT_THAT(placement.ended, IsEmpty());
  store.repair("expired_browsers");
  changes.end_expired_browsers();
  EXPECT_THAT(placement.ended, ElementsAre("from one of anna", "from two of bert"));
  EXPECT_THAT(store.expired, IsEmpty());
}

TEST_F(AccountChangesTest, SigningOutEverywhereEndsEveryBrowserAndSession) {
  ASSERT_TRUE(changes.sign_out_everywhere(who));
  EXPECT_THAT(store.ended, ElementsAre(who.user_id));
  EXPECT_THAT(placement.ended, ElementsAre("by " + who.user_id));
}

TEST_F(AccountChangesTest, ReportsAnUnavailableStore) {
  const std::string reset = reset_token(), change = change_token();
  const auto request_reset = [&] { return refusal(changes.request_reset("b@c.d", "5.6.7.8")); };
  const auto do_reset = [&] { return refusal(changes.reset(reset, new_password)); };
  const auto change_password = [&] {
    return refusal(changes.change_password(who, password, new_password));
  };
  const auto request_email = [&] {
    return refusal(changes.request_email(who, "other@example.org", password));
  };
  const auto confirm = [&] { return refusal(changes.confirm_email(who, change)); };
  const auto end = [&] { return refusal(changes.end_browser_session(who, new_id())); };
  expect_unavailable({
      {attempts, "note_attempt", request_reset},
      {store, "request_reset", request_reset},
      {store, "find_token", do_reset},
      {store, "reset", do_reset},
      {attempts, "find_by_id", change_password},
      {store, "change_password", change_password},
      {attempts, "find_by_id", request_email},
      {attempts, "note_attempt", request_email},
      {store, "request_email", request_email},
      {store, "find_token", confirm},
      {store, "confirm_email", confirm},
      {store, "browser_sessions", [&] { return refusal(changes.browser_sessions(who)); }},
      {store, "end_browser_session", end},
      {store, "end_browser_sessions", [&] { return refusal(changes.sign_out_everywhere(who)); }},
  });
  EXPECT_THAT(placement.ended, IsEmpty());
  EXPECT_EQ(woken, 2) << "no email was queued";
}

TEST_F(AccountChangesTest, ALimitThatCannotBeCountedSendsNoMail) {
  int counted_limits = 0;
  attempts.before("note_attempt", [&] {
    if (++counted_limits == 2) attempts.break_function("note_attempt");
  });
  EXPECT_EQ(refusal(changes.request_reset(who.email, "1.2.3.4")), ProblemKind::kUnavailable);
  attempts.repair("note_attempt");
  counted_limits = 0;
  EXPECT_EQ(refusal(changes.request_email(who, "new@example.org", password)),
            ProblemKind::kUnavailable);
  EXPECT_THAT(store.mails, IsEmpty());
  EXPECT_EQ(store.calls("request_email"), 0);
}

}  // namespace
}  // namespace diaphane::api
