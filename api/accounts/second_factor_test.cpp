#include "api/accounts/second_factor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <liboath/oath.h>

#include <array>
#include <set>

#include "api/accounts/totp.h"
#include "tests/support/api/fake_account_store.h"
#include "tests/support/api/fake_second_factor_store.h"
#include "tests/support/api/refusals.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

const std::string kRfcSecret = "12345678901234567890";

Time at(std::int64_t seconds) { return Time(std::chrono::seconds(seconds)); }

TEST(Totp, MatchesRfc6238TestVectors) {
  // RFC 6238, appendix B, SHA-1: the last six of the eight digits. The sixth vector is of the year
  // 2603, which the system clock cannot represent.
  const std::pair<std::int64_t, const char*> vectors[] = {{59, "287082"},
                                                          {1111111109, "081804"},
                                                          {1111111111, "050471"},
                                                          {1234567890, "005924"},
                                                          {2000000000, "279037"}};
  for (const auto& [seconds, code] : vectors) {
    EXPECT_EQ(totp::step_of(kRfcSecret, code, at(seconds), 0), seconds / 30) << seconds;
  }
  EXPECT_FALSE(totp::step_of(kRfcSecret, "287083", at(59), 0));
  EXPECT_FALSE(totp::step_of(kRfcSecret + "x", "287082", at(59), 0));
}

TEST(Totp, ToleratesClockSkewOfOneStep) {
  const std::int64_t seconds = 1111111111, step = seconds / 30;
  for (const std::int64_t apart : {-1, 0, 1}) {
    EXPECT_EQ(totp::step_of(kRfcSecret, "050471", at(seconds + apart * 30), 0), step) << apart;
  }
  EXPECT_FALSE(totp::step_of(kRfcSecret, "050471", at(seconds - 60), 0));
  EXPECT_FALSE(totp::step_of(kRfcSecret, "050471", at(seconds + 60), 0));
}

TEST(Totp, RefusesReplayedAndEarlierCodes) {
  const std::int64_t step = 1111111111 / 30;
  EXPECT_TRUE(totp::step_of(kRfcSecret, "050471", at(1111111111), step - 1));
  EXPECT_FALSE(totp::step_of(kRfcSecret, "050471", at(1111111111), step));
  EXPECT_FALSE(totp::step_of(kRfcSecret, "081804", at(1111111111), step)) << "the one before";
}

TEST(Totp, AcceptsSpacesAndRefusesMalformedCodes) {
  EXPECT_TRUE(totp::step_of(kRfcSecret, "287 082", at(59), 0));
  for (const char* bad : {"", "28708", "2870820", "+87082", "287082\n", "éééééé"}) {
    EXPECT_FALSE(totp::step_of(kRfcSecret, bad, at(59), 0)) << bad;
  }
}

TEST(Totp, UriFollowsKeyUriFormat) {
  EXPECT_EQ(totp::uri(kRfcSecret, "a+b@example.org"),
            "otpauth://totp/Diaphane:a%2Bb%40example.org?secret=GEZDGNBVGY3TQOJQGEZDGNBVGY3TQOJQ"
            "&issuer=Diaphane&algorithm=SHA1&digits=6&period=30");
  EXPECT_EQ(totp::new_secret().size(), 20u);
  EXPECT_NE(totp::new_secret(), totp::new_secret());
}

TEST(SealingKey, OpensOnlyItsOwnCiphertextForTheSameContext) {
  const auto key = SealingKey::of_hex(std::string(64, 'a')).value();
  const std::string sealed = key.seal("secret", "anna");
  EXPECT_EQ(sealed.find("secret"), std::string::npos);
  EXPECT_NE(key.seal("secret", "anna"), sealed);
  EXPECT_EQ(key.open(sealed, "anna"), "secret");
  EXPECT_FALSE(key.open(sealed, "bert"));
  EXPECT_FALSE(SealingKey::of_hex(std::string(64, 'b'))->open(sealed, "anna"));
  for (std::size_t i = 0; i < sealed.size(); i += 7) {
    std::string damaged = sealed;
    damaged[i] = damaged[i] == '0' ? '1' : '0';
    EXPECT_FALSE(key.open(damaged, "anna")) << i;
  }
  for (const std::string& bad : {std::string(), std::string("zz"), sealed.substr(0, 40)}) {
    EXPECT_FALSE(key.open(bad, "anna")) << bad;
  }
  for (const std::string& bad : {std::string(), std::string(63, 'a'), std::string(64, 'g')}) {
    EXPECT_FALSE(SealingKey::of_hex(bad)) << bad;
  }
  EXPECT_FALSE(SealingKey::read("/nonexistent"));
}

TEST(RecoveryCodes, GeneratesTenCodesAndToleratesTypingVariants) {
  const auto codes = new_recovery_codes();
  EXPECT_EQ(std::set<std::string>(codes.begin(), codes.end()).size(), 10u);
  EXPECT_THAT(codes[0], testing::MatchesRegex("([a-z2-7]{4}-){5}[a-z2-7]{4}"));
  const auto hash = recovery_code_hash("oabl-efgh-ijkl-mnop-qrst-uvwx");
  ASSERT_TRUE(hash);
  EXPECT_EQ(recovery_code_hash("0A81 EFGHIJKL mnop qrst uvwx"), hash);
  EXPECT_EQ(recovery_code_hash(codes[0]), recovery_code_hash(" " + codes[0]));
  for (const char* bad :
       {"", "123456", "oabl-efgh-ijkl-mnop-qrst-uvw", "oabl-efgh-ijkl-mnop-qrst-uvw9"}) {
    EXPECT_FALSE(recovery_code_hash(bad)) << bad;
  }
}

/// An account whose second factor is set up through the public interface.
class SecondFactorTest : public testing::Test {
 protected:
  void SetUp() override {
    clock.advance(1111111111s);
    ASSERT_TRUE(accounts.sign_up(kEmail, Consent::kGiven, "1.2.3.4"));
    const std::string& body = store.mails.back().body;
    ASSERT_TRUE(accounts.verify(body.substr(body.find("#token=") + 7, 64), kPassword));
    who.user_id = store.accounts.begin()->second.id;
    who.email = kEmail;
  }
  /// Returns the code that the device shows `steps` steps from now.
  std::string code(std::int64_t steps = 0) const {
    const auto secret = key.open(factors.factors.at(who.user_id).sealed_secret, who.user_id);
    std::array<char, 7> shown{};
    EXPECT_EQ(oath_hotp_generate(
                  secret->data(), secret->size(),
                  static_cast<std::uint64_t>(clock.wall().time_since_epoch() / 30s + steps), 6,
                  false, OATH_HOTP_DYNAMIC_TRUNCATION, shown.data()),
              OATH_OK);
    return shown.data();
  }
  std::vector<std::string> set_up() {
    EXPECT_TRUE(second.begin(who, kPassword));
    auto codes = second.confirm(who, code());
    EXPECT_TRUE(codes);
    who.second_factor = true;
    return codes ? *codes : std::vector<std::string>();
  }
  ProblemKind refused(const std::string& with) {
    const auto opened = accounts.sign_in(kEmail, kPassword, with, "1.2.3.4");
    EXPECT_FALSE(opened);
    return opened ? ProblemKind::kInternal : opened.error().kind;
  }
  bool let_in(const std::string& with) {
    return accounts.sign_in(kEmail, kPassword, with, "1.2.3.4").has_value();
  }

  const std::string kEmail = "person@example.org", kPassword = "a long and quiet password";
  FakeAccountStore store;
  FakeSecondFactorStore factors;
  ManualClock clock;
  Signals signals;
  FakePasswordHasher hasher;
  const SealingKey key = SealingKey::of_hex(std::string(64, '1')).value();
  CodeCheck check{factors, store, key, clock, signals, {.public_url = "https://see.example"}};
  Accounts accounts{
      store, hasher, check, key, clock, signals, {.public_url = "https://see.example"}};
  SecondFactors second{factors, accounts, check, key, clock, signals, {}};
  Principal who;
};

TEST_F(SecondFactorTest, SignInRequiresFreshCodeAfterSetUp) {
  ASSERT_TRUE(second.begin(who, kPassword));
  EXPECT_TRUE(let_in("")) << "begun is not set up";
  ASSERT_TRUE(second.confirm(who, code()));
  EXPECT_EQ(refused(""), ProblemKind::kCodeNeeded);
  EXPECT_EQ(refused("123456"), ProblemKind::kWrongCode);
  EXPECT_THAT(factors.mails.back().subject, testing::Not(HasSubstr("twice")));
  EXPECT_EQ(refused(code()), ProblemKind::kWrongCode) << "it confirmed already";
  EXPECT_THAT(factors.mails.back().subject, HasSubstr("twice"));
  EXPECT_TRUE(let_in(code(1)));
  EXPECT_EQ(refused(code(1)), ProblemKind::kWrongCode);
  clock.advance(60s);
  EXPECT_EQ(refused(code(-1)), ProblemKind::kWrongCode) << "seen before, now a step old";
  EXPECT_TRUE(let_in(code()));
}

TEST_F(SecondFactorTest, ChecksPasswordBeforeCode) {
  set_up();
  const auto opened = accounts.sign_in(kEmail, "not the password", code(1), "1.2.3.4");
  EXPECT_EQ(opened.error().kind, ProblemKind::kWrongCredentials);
  EXPECT_TRUE(let_in(code(1))) << "and none is used up";
}

TEST_F(SecondFactorTest, LimitsCodeGuessesOverMinutesAndDays) {
  set_up();
  for (int i = 0; i < 5; ++i)
    EXPECT_EQ(refused("00000" + std::to_string(i)), ProblemKind::kWrongCode);
  EXPECT_EQ(refused(code(1)), ProblemKind::kTooManyAttempts);
  for (int quarter = 0; quarter < 3; ++quarter) {
    clock.advance(16min);
    for (int i = 0; i < 5; ++i) refused("00000" + std::to_string(i));
  }
  clock.advance(16min);
  EXPECT_EQ(refused(code(1)), ProblemKind::kTooManyAttempts) << "twenty in a day";
  clock.advance(24h);
  EXPECT_TRUE(let_in(code()));
}

TEST_F(SecondFactorTest, RecoveryCodeWorksOnceAndItsUseIsMailed) {
  const auto codes = set_up();
  EXPECT_TRUE(let_in(codes[3]));
  EXPECT_THAT(factors.mails.back().subject, HasSubstr("recovery code"));
  EXPECT_EQ(refused(codes[3]), ProblemKind::kWrongCode);
  EXPECT_EQ(second.state(who)->recovery_codes, 9);
  const auto fresh = second.renew_recovery_codes(who, kPassword, codes[4]);
  ASSERT_TRUE(fresh);
  EXPECT_EQ(refused(codes[5]), ProblemKind::kWrongCode);
  EXPECT_TRUE(let_in(fresh->front()));
}

TEST_F(SecondFactorTest, UnconfirmedSetUpExpiresAndConfirmedSetUpIsNotReplaced) {
  EXPECT_EQ(second.confirm(who, "123456").error().kind, ProblemKind::kConflict);
  ASSERT_TRUE(second.begin(who, kPassword));
  const std::string first = code();
  ASSERT_TRUE(second.begin(who, kPassword));
  EXPECT_EQ(second.confirm(who, first).error().kind, ProblemKind::kInvalid)
      << "of the first secret";
  clock.advance(61min);
  EXPECT_EQ(second.confirm(who, code()).error().kind, ProblemKind::kConflict);
  set_up();
  EXPECT_EQ(second.begin(who, kPassword).error().kind, ProblemKind::kConflict);
  EXPECT_EQ(second.begin(who, "wrong").error().kind, ProblemKind::kInvalid);
}

TEST_F(SecondFactorTest, RemovalRequiresPasswordAndCode) {
  EXPECT_EQ(second.remove(who, kPassword, "123456").error().kind, ProblemKind::kConflict);
  set_up();
  EXPECT_EQ(second.remove(who, "wrong", code(1)).error().fields[0].field, "password");
  EXPECT_EQ(second.remove(who, kPassword, code()).error().fields[0].field, "code");
  ASSERT_TRUE(second.remove(who, kPassword, code(1)));
  EXPECT_THAT(factors.mails.back().subject, HasSubstr("is now off"));
  EXPECT_TRUE(let_in(""));
}

TEST_F(SecondFactorTest, ConfirmingItEndsOtherBrowsersAndSendsAMail) {
  int signed_out = 0, woken = 0;
  signals.subscribe(Signal::kSignOut, [&] { ++signed_out; });
  signals.subscribe(Signal::kMail, [&] { ++woken; });
  ASSERT_TRUE(second.begin(who, kPassword));
  EXPECT_EQ(invalid_field(second.confirm(who, "123456")), "code");
  EXPECT_EQ(signed_out + woken, 0);
  ASSERT_TRUE(second.confirm(who, code()));
  EXPECT_EQ(signed_out, 1);
  EXPECT_EQ(woken, 1);
}

TEST_F(SecondFactorTest, OnlyOneOfTwoConcurrentRequestsMayUseACode) {
  set_up();
  factors.before("take_step", [&] { factors.factors[who.user_id].last_step = 1 << 30; });
  EXPECT_EQ(refused(code(1)), ProblemKind::kWrongCode);
  EXPECT_THAT(factors.mails.back().subject, HasSubstr("twice"));
}

TEST_F(SecondFactorTest, AdministratorRequiresSecondFactor) {
  EXPECT_FALSE(second.state(who)->required);
  who.administrator_waits = true;
  EXPECT_TRUE(second.state(who)->required);
  EXPECT_FALSE(second.state(who)->set_up_at);
  ASSERT_TRUE(second.begin(who, kPassword));
  EXPECT_FALSE(second.state(who)->set_up_at) << "begun is not set up";
  ASSERT_TRUE(second.confirm(who, code()));
  EXPECT_EQ(second.state(who)->set_up_at, clock.wall());
  EXPECT_EQ(second.state(who)->recovery_codes, 10);
}

TEST_F(SecondFactorTest, EachStepThatFailsIsReportedAsUnavailable) {
  const auto begin = [&] { return refusal(second.begin(who, kPassword)); };
  const auto confirm = [&] { return refusal(second.confirm(who, code())); };
  expect_unavailable({{store, "find_by_id", begin}, {factors, "begin", begin}});
  ASSERT_TRUE(second.begin(who, kPassword));
  expect_unavailable({{factors, "find", confirm}, {factors, "confirm", confirm}});
  const auto codes = set_up();
  const auto take = [&](const std::string& with) {
    return
        [this, with] { return refusal(check.take(who.user_id, kEmail, with, Language::kEnglish)); };
  };
  const auto renew = [&] { return refusal(second.renew_recovery_codes(who, kPassword, codes[0])); };
  const auto remove = [&] { return refusal(second.remove(who, kPassword, codes[1])); };
  expect_unavailable({
      {factors, "find", [&] { return refusal(second.state(who)); }},
      {factors, "find", [&] { return refusal(check.needed(who.user_id)); }},
      {store, "note_attempt", take(code(1))},
      {factors, "find", take(code(1))},
      {factors, "take_step", take(code(1))},
      {factors, "note_reuse", take(code())},
      {factors, "take_recovery_code", take(codes[2])},
      {store, "forget_attempts", take(codes[3])},
  });
  store.attempts.clear();
  expect_unavailable({{factors, "renew_recovery_codes", renew}, {factors, "remove", remove}});
}

TEST_F(SecondFactorTest, WithAnotherKeyCodesCannotBeCheckedButRecoveryCodesCan) {
  const auto codes = set_up();
  const SealingKey other = SealingKey::of_hex(std::string(64, '2')).value();
  CodeCheck blind{factors, store, other, clock, signals, {}};
  EXPECT_EQ(blind.take(who.user_id, kEmail, code(1), Language::kEnglish).error().kind,
            ProblemKind::kInternal);
  EXPECT_TRUE(blind.take(who.user_id, kEmail, codes[0], Language::kEnglish).value());
}

}  // namespace
}  // namespace diaphane::api
