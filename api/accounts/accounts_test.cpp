#include "api/accounts/accounts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "api/shared/secrets.h"
#include "tests/support/api/fake_account_store.h"
#include "tests/support/api/fake_second_factor_store.h"
#include "tests/support/api/refusals.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;

const std::string kEmail = "Person@example.org";
const std::string kPassword = "a long and quiet password";

class AccountsTest : public testing::Test {
 protected:
  std::string token_in_last_mail() const {
    const std::string& body = store.mails.back().body;
    return body.substr(body.find("#token=") + 7, 64);
  }
  void sign_up_and_verify() {
    ASSERT_TRUE(accounts.sign_up(kEmail, Consent::kGiven, "1.2.3.4"));
    ASSERT_TRUE(accounts.verify(token_in_last_mail(), kPassword));
  }
  ProblemKind refused_sign_in(const std::string& password, const std::string& address = "1.2.3.4") {
    const auto opened = accounts.sign_in(kEmail, password, "", address);
    EXPECT_FALSE(opened);
    return opened ? ProblemKind::kInternal : opened.error().kind;
  }

  FakeAccountStore store;
  ManualClock clock;
  Signals signals;
  FakePasswordHasher hasher;
  FakeSecondFactorStore factors;
  const SealingKey key = SealingKey::of_hex(std::string(64, '1')).value();
  CodeCheck codes{factors, store, key, clock, signals, {}};
  Accounts accounts{
      store, hasher, codes, key, clock, signals, {.public_url = "https://see.example"}};
};

TEST_F(AccountsTest, StoredDataDoesNotAuthenticate) {
  sign_up_and_verify();
  const auto opened = accounts.sign_in(kEmail, kPassword, "", "1.2.3.4");
  ASSERT_TRUE(opened);
  EXPECT_EQ(store.sessions.count(opened->token), 0u);
  EXPECT_FALSE(accounts.authenticate(store.sessions.begin()->first));
  EXPECT_EQ(store.accounts.begin()->second.password_hash.find(kPassword), std::string::npos);
}

TEST_F(AccountsTest, ALinkWorksOnce) {
  ASSERT_TRUE(accounts.sign_up(kEmail, Consent::kGiven, "1.2.3.4"));
  EXPECT_EQ(refused_sign_in(kPassword), ProblemKind::kWrongCredentials);
  const std::string token = token_in_last_mail();
  EXPECT_EQ(accounts.verify(token, "short").error().kind, ProblemKind::kInvalid);
  EXPECT_EQ(refused_sign_in("short"), ProblemKind::kWrongCredentials);
  EXPECT_TRUE(accounts.verify(token, kPassword));
  EXPECT_EQ(accounts.verify(token, kPassword).error().kind, ProblemKind::kLinkExpired);
}

TEST_F(AccountsTest, ChoosingThePasswordSignsInOnlyThatBrowser) {
  ASSERT_TRUE(accounts.sign_up(kEmail, Consent::kGiven, "1.2.3.4"));
  const std::string token = token_in_last_mail();
  EXPECT_FALSE(accounts.verify(token, "short"));
  EXPECT_FALSE(accounts.verify(std::string(64, '0'), kPassword));
  EXPECT_TRUE(store.sessions.empty()) << "neither the link nor a password alone signs in";
  const auto opened = accounts.verify(token, kPassword, "Firefox on Windows");
  ASSERT_TRUE(opened);
  EXPECT_EQ(accounts.authenticate(opened->token)->user_id, store.accounts.begin()->second.id);
  EXPECT_FALSE(accounts.verify(token, kPassword));
  EXPECT_EQ(store.sessions.size(), 1u) << "a used link opens no session";
  EXPECT_EQ(store.sessions.begin()->second.browser, "Firefox on Windows");
  for (int i = 0; i < 10; ++i) refused_sign_in("wrong wrong");
  EXPECT_TRUE(accounts.sign_in(kEmail, kPassword, "", "1.2.3.4", "", opened->known_browser))
      << "this browser is known from now on";
}

TEST_F(AccountsTest, ConfirmingADisabledAccountDoesNotSignIn) {
  ASSERT_TRUE(accounts.sign_up(kEmail, Consent::kGiven, "1.2.3.4"));
  store.accounts.begin()->second.disabled = true;
  const auto opened = accounts.verify(token_in_last_mail(), kPassword);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().kind, ProblemKind::kDisabled);
  EXPECT_TRUE(store.sessions.empty());
}

TEST_F(AccountsTest, AnyMailedLinkWorksDespiteRepeatedSignUps) {
  for (int i = 0; i < 6; ++i)
    ASSERT_TRUE(accounts.sign_up(kEmail, Consent::kGiven, std::to_string(i)));
  ASSERT_EQ(store.mails.size(), 4u) << "a mailbox is not filled by strangers";
  const std::string newest = token_in_last_mail();
  ASSERT_TRUE(accounts.sign_up(kEmail, Consent::kGiven, "the owner"));
  EXPECT_EQ(token_in_last_mail(), newest) << "the owner is mailed nothing";
  store.mails.erase(store.mails.begin() + 1, store.mails.end());
  const std::string oldest = token_in_last_mail();

  ASSERT_TRUE(accounts.verify(oldest, kPassword)) << "any link that was mailed works";
  EXPECT_TRUE(accounts.sign_in(kEmail, kPassword, "", "the owner"));
  EXPECT_EQ(accounts.verify(newest, "another long password").error().kind,
            ProblemKind::kLinkExpired)
      << "the other links no longer work";
}

TEST_F(AccountsTest, SigningUpAgainLeavesEarlierLinksValid) {
  ASSERT_TRUE(accounts.sign_up(kEmail, Consent::kGiven, "1.2.3.4"));
  const std::string mine = token_in_last_mail();
  ASSERT_TRUE(accounts.sign_up(kEmail, Consent::kGiven, "an attacker"));
  EXPECT_TRUE(accounts.verify(mine, kPassword));
}

TEST_F(AccountsTest, AddressIsCaseInsensitive) {
  sign_up_and_verify();
  EXPECT_TRUE(accounts.sign_in("PERSON@EXAMPLE.ORG", kPassword, "", "1.2.3.4"));
}

TEST_F(AccountsTest, SigningUpWithKnownAddressDoesNotRevealTheAccount) {
  sign_up_and_verify();
  const std::string hash = store.accounts.begin()->second.password_hash;
  EXPECT_TRUE(accounts.sign_up(kEmail, Consent::kGiven, "9.9.9.9"));
  EXPECT_EQ(store.accounts.begin()->second.password_hash, hash);
  EXPECT_THAT(store.mails.back().subject, testing::HasSubstr("already"));
}

TEST_F(AccountsTest, TenFailuresLockAccountForFifteenMinutes) {
  sign_up_and_verify();
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(refused_sign_in("wrong wrong", std::to_string(i)), ProblemKind::kWrongCredentials);
  }
  EXPECT_EQ(refused_sign_in(kPassword, "other"), ProblemKind::kTooManyAttempts);
  clock.advance(15min);
  EXPECT_TRUE(accounts.sign_in(kEmail, kPassword, "", "other"));
}

TEST_F(AccountsTest, StrangersFailuresDoNotLockOutABrowserThatHasSignedInBefore) {
  sign_up_and_verify();
  const auto before = accounts.sign_in(kEmail, kPassword, "", "home");
  ASSERT_TRUE(before);
  const std::string known = before->known_browser;
  for (int i = 0; i < 10; ++i) refused_sign_in("wrong wrong", "home");
  EXPECT_EQ(refused_sign_in(kPassword, "home"), ProblemKind::kTooManyAttempts);
  const auto sign_in = [&](const std::string& password, const std::string& cookie) {
    return accounts.sign_in(kEmail, password, "", "home", "", cookie);
  };
  EXPECT_TRUE(accounts.confirm_password(before->principal, "password", kPassword));
  EXPECT_EQ(sign_in(kPassword, known)->known_browser, known);
  EXPECT_EQ(refused_sign_in(kPassword, "home"), ProblemKind::kTooManyAttempts)
      << "a known browser clears no counter but its own";

  // The known browser's own attempts are counted.
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(sign_in("wrong wrong", known).error().kind, ProblemKind::kWrongCredentials);
  }
  EXPECT_EQ(sign_in(kPassword, known).error().kind, ProblemKind::kTooManyAttempts);

  // Rejects a forged cookie, a cookie of another account, and a cookie from before a password
  // change.
  clock.advance(15min);
  for (int i = 0; i < 10; ++i) refused_sign_in("wrong wrong", "home");
  std::string forged = known;
  forged.back() = forged.back() == '0' ? '1' : '0';
  for (const std::string& cookie : {forged, std::string(64, 'a'), known + "0", std::string()}) {
    EXPECT_EQ(sign_in(kPassword, cookie).error().kind, ProblemKind::kTooManyAttempts);
  }
  EXPECT_TRUE(sign_in(kPassword, known));
  store.accounts.begin()->second.password_hash = *hasher.hash(kPassword);
  EXPECT_EQ(sign_in(kPassword, known).error().kind, ProblemKind::kTooManyAttempts);
}

TEST_F(AccountsTest, SuccessfulSignInResetsAccountLimitButNotAddressLimit) {
  sign_up_and_verify();
  for (int i = 0; i < 9; ++i) refused_sign_in("wrong wrong");
  clock.advance(1s);
  ASSERT_TRUE(accounts.sign_in(kEmail, kPassword, "", "1.2.3.4"));
  // The nine failures of the address still count: after 41 more, it must wait for any account.
  for (int i = 0; i < 41; ++i) {
    EXPECT_EQ(accounts.sign_in("x" + std::to_string(i) + "@b.c", "wrong wrong", "", "1.2.3.4")
                  .error()
                  .kind,
              ProblemKind::kWrongCredentials);
  }
  EXPECT_EQ(refused_sign_in(kPassword), ProblemKind::kTooManyAttempts);
}

TEST_F(AccountsTest, SessionExtendsWithUseUpToItsLimit) {
  sign_up_and_verify();
  const std::string token = accounts.sign_in(kEmail, kPassword, "", "1.2.3.4")->token;
  EXPECT_FALSE(accounts.authenticate(token)->renewed);
  for (int day = 0; day < 29; ++day) {
    ASSERT_TRUE(accounts.authenticate(token)) << "day " << day;
    clock.advance(24h);
  }
  EXPECT_TRUE(accounts.authenticate(token));
  EXPECT_LT(store.extended, 29);  // does not write on each use
  clock.advance(25h);
  EXPECT_EQ(accounts.authenticate(token).error().kind, ProblemKind::kUnauthenticated);
}

TEST_F(AccountsTest, SessionExpiresWithoutUse) {
  sign_up_and_verify();
  const std::string token = accounts.sign_in(kEmail, kPassword, "", "1.2.3.4")->token;
  clock.advance(14 * 24h);
  EXPECT_FALSE(accounts.authenticate(token));
}

TEST_F(AccountsTest, AnAdministratorSignsInAgainAfterHalfAnHourWithoutUseAndTwelveHoursWithIt) {
  sign_up_and_verify();
  const auto signed_in = [&] { return accounts.sign_in(kEmail, kPassword, "", "1.2.3.4")->token; };
  for (const bool factor : {true, false}) {  // the role alone is sufficient
    store.administrator = true;
    store.second_factor = false;
    const std::string left = signed_in(), used = signed_in();
    store.second_factor = factor;
    for (auto at = 0min; at < 12h; at += 15min) {
      ASSERT_TRUE(accounts.authenticate(used)) << at.count() << " minutes";
      clock.advance(15min);
      if (at == 15min) EXPECT_FALSE(accounts.authenticate(left));
    }
    EXPECT_EQ(accounts.authenticate(used).error().kind, ProblemKind::kUnauthenticated);
    store.administrator = false;
    EXPECT_FALSE(accounts.authenticate(used)) << "it is over, whatever became of the role";
  }
}

TEST_F(AccountsTest, ShorterPasswordsOfOldAccountsStillWork) {
  sign_up_and_verify();
  store.accounts.begin()->second.password_hash = *hasher.hash("kq7 zr4 vm");
  EXPECT_TRUE(accounts.sign_in(kEmail, "kq7 zr4 vm", "", "1.2.3.4"));
}

TEST_F(AccountsTest, OnlyTheHolderOfThePasswordLearnsThatAnAccountIsDisabled) {
  sign_up_and_verify();
  store.sessions.clear();
  store.accounts.begin()->second.disabled = true;
  EXPECT_EQ(refused_sign_in("wrong wrong"), ProblemKind::kWrongCredentials);
  EXPECT_EQ(refused_sign_in(kPassword), ProblemKind::kDisabled);
  EXPECT_TRUE(store.sessions.empty());
}

TEST_F(AccountsTest, LimitsSignUpsPerAddressToThirtyPerQuarterHour) {
  EXPECT_EQ(invalid_field(accounts.sign_up("person", Consent::kGiven, "1.2.3.4")), "email");
  for (int i = 0; i < 30; ++i) {
    ASSERT_TRUE(accounts.sign_up(std::to_string(i) + "@example.org", Consent::kGiven, "1.2.3.4"));
  }
  EXPECT_EQ(refusal(accounts.sign_up(kEmail, Consent::kGiven, "1.2.3.4")),
            ProblemKind::kTooManyAttempts);
  EXPECT_EQ(store.mails.size(), 30u);
  EXPECT_TRUE(accounts.sign_up(kEmail, Consent::kGiven, "5.6.7.8"));
  clock.advance(15min);
  EXPECT_TRUE(accounts.sign_up("x@example.org", Consent::kGiven, "1.2.3.4"));
}

TEST_F(AccountsTest, SigningUpNeedsConsentAndStoresItsVersion) {
  EXPECT_EQ(invalid_field(accounts.sign_up(kEmail, Consent::kMissing, "1.2.3.4")), "consent");
  EXPECT_TRUE(store.accounts.empty());
  EXPECT_TRUE(store.mails.empty());
  sign_up_and_verify();
  const Principal who = accounts.sign_in(kEmail, kPassword, "", "1.2.3.4")->principal;
  EXPECT_EQ(accounts.consent_at(who).value(), clock.wall());
  EXPECT_EQ(store.consents.at(who.user_id).first, kPrivacyTemplate);
}

TEST_F(AccountsTest, ANewPrivacyNoticeNeedsNewConsent) {
  sign_up_and_verify();
  Accounts later{store, hasher, codes, key, clock, signals, {.consent_version = "2027-01-01"}};
  const Principal who = later.sign_in(kEmail, kPassword, "", "1.2.3.4")->principal;
  EXPECT_FALSE(later.consent_at(who).value());
  EXPECT_EQ(invalid_field(later.give_consent(who, kPrivacyTemplate)), "version");
  EXPECT_FALSE(later.consent_at(who).value());
  clock.advance(1h);
  ASSERT_TRUE(later.give_consent(who, "2027-01-01"));
  EXPECT_EQ(later.consent_at(who).value(), clock.wall());
  EXPECT_FALSE(accounts.consent_at(who).value());
}

TEST_F(AccountsTest, SigningOutEndsTheSessionAndItsStreams) {
  sign_up_and_verify();
  int ended = 0;
  signals.subscribe(Signal::kSignOut, [&] { ++ended; });
  const std::string token = accounts.sign_in(kEmail, kPassword, "", "1.2.3.4")->token;
  ASSERT_TRUE(accounts.sign_out(token));
  EXPECT_EQ(ended, 1);
  EXPECT_EQ(refusal(accounts.authenticate(token)), ProblemKind::kUnauthenticated);
  EXPECT_EQ(refusal(accounts.authenticate("no token")), ProblemKind::kUnauthenticated);
}

TEST_F(AccountsTest, RequestWithoutRenewalWritesNothing) {
  sign_up_and_verify();
  const std::string token = accounts.sign_in(kEmail, kPassword, "", "1.2.3.4")->token;
  clock.advance(5 * 24h);
  EXPECT_FALSE(accounts.authenticate(token, Accounts::Renewal::kNo)->renewed);
  EXPECT_EQ(store.calls("extend_session") + store.calls("touch_session"), 0);
  EXPECT_TRUE(accounts.authenticate(token)->renewed);
}

TEST_F(AccountsTest, EachStepThatFailsIsReportedAsUnavailable) {
  sign_up_and_verify();
  ASSERT_TRUE(accounts.sign_up("other@example.org", Consent::kGiven, "1.2.3.4"));
  const std::string link = token_in_last_mail();
  const std::string token = accounts.sign_in(kEmail, kPassword, "", "1.2.3.4")->token;
  const Principal who = accounts.authenticate(token).value();
  clock.advance(5 * 24h);
  EXPECT_EQ(invalid_field(accounts.verify("no token", kPassword)), "token");
  EXPECT_EQ(invalid_field(accounts.confirm_password(who, "password", "wrong")), "password");
  const auto sign_up = [&] {
    return refusal(accounts.sign_up("new@example.org", Consent::kGiven, "1.2.3.4"));
  };
  const auto verify = [&] { return refusal(accounts.verify(link, kPassword)); };
  const auto sign_in = [&] { return refusal(accounts.sign_in(kEmail, kPassword, "", "1.2.3.4")); };
  const auto confirm = [&] { return refusal(accounts.confirm_password(who, "p", kPassword)); };
  const auto authenticate = [&] { return refusal(accounts.authenticate(token)); };
  expect_unavailable({
      {store, "note_attempt", sign_up},
      {store, "sign_up", sign_up},
      {store, "find_sign_up", verify},
      {store, "verify", verify},
      {store, "find_by_email", verify},
      {store, "find_by_email", sign_in},
      {store, "note_attempt", sign_in},
      {store, "forget_attempts", sign_in},
      {factors, "find", sign_in},
      {store, "open_session", sign_in},
      {store, "find_session", sign_in},
      {store, "find_by_id", confirm},
      {store, "note_attempt", confirm},
      {store, "forget_attempts", confirm},
      {store, "find_session", authenticate},
      {store, "touch_session", authenticate},
      {store, "extend_session", authenticate},
      {store, "close_session", [&] { return refusal(accounts.sign_out(token)); }},
      {store, "quota_of", [&] { return refusal(accounts.quota_of(who.user_id)); }},
  });
  EXPECT_EQ(accounts.quota_of(who.user_id)->bytes, 1000);
}

TEST_F(AccountsTest, UnavailableDatabaseIsNotReportedAsWrongPassword) {
  sign_up_and_verify();
  store.away = true;
  EXPECT_EQ(refused_sign_in(kPassword), ProblemKind::kUnavailable);
  EXPECT_EQ(accounts.authenticate(std::string(64, 'a')).error().kind, ProblemKind::kUnavailable);
}

TEST(Password, RefusesWrongLengthAndOwnEmailAddress) {
  EXPECT_TRUE(fault_of_password("kq7 zr4 vm2", kEmail));
  EXPECT_FALSE(fault_of_password("kq7 zr4 vm2x", kEmail));
  EXPECT_TRUE(fault_of_password("éàüöèçñâêîû", kEmail));  // 22 bytes, 11 characters
  EXPECT_FALSE(fault_of_password("éàüöèçñâêîûô", kEmail));
  std::string long_one;
  while (long_one.size() < 200) long_one += std::to_string(long_one.size()) + "-";
  EXPECT_FALSE(fault_of_password(long_one.substr(0, 200), kEmail));
  EXPECT_TRUE(fault_of_password(long_one.substr(0, 200) + "x", kEmail));
  EXPECT_TRUE(fault_of_password("pErson@example.ORG", kEmail));
}

TEST(Password, RefusesCommonPasswords) {
  for (const char* guessed :
       {"123456789012", "Qwertyuiop12", "password1234", "Football2023!", "!!!dragon!!!",
        "iloveyou-2012", "aaaaaaaaaaaa", "abcabcabcabc", "passwordpassword", "abcdefghijkl",
        "987654321098", "Diaphane2026", "tellerman1999"}) {
    EXPECT_TRUE(fault_of_password(guessed, "tellerman@example.org")) << guessed;
  }
  for (const char* well :
       {"correct horse battery", "dragon and football", "Tr0ub4dor&3x", "tellerman likes tea",
        "1234567890 as my pin", "football 1954 in bern"}) {
    EXPECT_FALSE(fault_of_password(well, "tellerman@example.org")) << well;
  }
}

TEST(Password, TheHashIsSaltedAndVerifiesOnlyItself) {
  PasswordHasher hasher(1);
  const auto a = hasher.hash(kPassword), b = hasher.hash(kPassword);
  EXPECT_NE(*a, *b);
  EXPECT_TRUE(a->starts_with("$argon2id$v=19$m=19456,t=2,p=1$")) << *a;
  EXPECT_TRUE(*hasher.verify(kPassword, *a));
  EXPECT_FALSE(*hasher.verify(kPassword + " ", *a));
  EXPECT_FALSE(*hasher.verify_dummy(kPassword));
}

TEST(Password, BoundsConcurrentHashing) {
  PasswordHasher hasher(1, 1ms);
  std::atomic<int> done = 0, refused = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 20; ++i) {
    threads.emplace_back([&] { ++(hasher.hash(kPassword) ? done : refused); });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_GE(done, 1);
  EXPECT_GE(refused, 1);
  EXPECT_TRUE(hasher.hash(kPassword));  // afterwards, there is room again
}

TEST(Email, AcceptsOnlyDeliverableAddresses) {
  for (const char* good : {"a@b", "first.last+tag@example.co.uk", "x_y@1-2.de"}) {
    EXPECT_TRUE(is_email(good)) << good;
  }
  for (const char* bad : {"", "a", "@b", "a@", "a@b@c", "a b@c", "a@.b", "a@b.", "a@b..c", "<a@b>",
                          "a@b\r\nBcc: c@d", "é@b"}) {
    EXPECT_FALSE(is_email(bad)) << bad;
  }
}

}  // namespace
}  // namespace diaphane::api
