#include "api/privacy/account_deletion.h"

#include <gmock/gmock.h>

#include "tests/support/api/account_fixture.h"

namespace diaphane::api {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

class FakeAccountDeletionStore final : public AccountDeletionStore, public Fake {
 public:
  std::vector<std::string> removed, attempt_keys;
  std::vector<Mail> mails;

  Result<std::vector<std::string>> remove_account(const std::string& user_id, const std::string&,
                                                  const std::vector<std::string>& keys,
                                                  const Mail& notification, Time) override {
    DIAPHANE_TRY(enter("remove_account"));
    removed.push_back(user_id);
    attempt_keys = keys;
    mails.push_back(notification);
    return std::vector<std::string>{"a", "b"};
  }
};

class AccountDeletionTest : public AccountFixture {
 protected:
  AccountDeletionTest() {
    signals.subscribe(Signal::kDisposal, [this] { ++disposals; });
    signals.subscribe(Signal::kMail, [this] { ++mails; });
  }

  FakeAccountDeletionStore store;
  int disposals = 0, mails = 0;
  AccountDeletion deletion{store, accounts, placement, clock, signals};
};

TEST_F(AccountDeletionTest, AnAccountIsDeletedOnlyWithItsPassword) {
  EXPECT_EQ(invalid_field(deletion.remove(who, "wrong wrong", "")), "password");
  EXPECT_EQ(invalid_field(deletion.remove(who, "", "")), "password");
  EXPECT_THAT(store.removed, IsEmpty());
  EXPECT_THAT(placement.ended, IsEmpty());
  EXPECT_EQ(disposals + mails, 0);
  ASSERT_TRUE(deletion.remove(who, password, ""));
  EXPECT_THAT(store.removed, ElementsAre(who.user_id));
  EXPECT_EQ(disposals, 1);
  EXPECT_EQ(mails, 1);
}

TEST_F(AccountDeletionTest, AnAccountWithASecondFactorIsDeletedOnlyWithACode) {
  factors.factors[who.user_id] = {"", clock.wall(), clock.wall(), 0, 0};
  factors.codes[who.user_id] = {recovery_code_hash("abcd-efgh-ijkl-mnop-qrst-uvwx").value()};
  EXPECT_EQ(refusal(deletion.remove(who, password, "")), ProblemKind::kCodeNeeded);
  EXPECT_EQ(invalid_field(deletion.remove(who, "wrong wrong", "")), "password");
  EXPECT_THAT(store.removed, IsEmpty());
  EXPECT_TRUE(deletion.remove(who, password, "abcd-efgh-ijkl-mnop-qrst-uvwx"));
  EXPECT_THAT(store.removed, ElementsAre(who.user_id));
}

TEST_F(AccountDeletionTest, LimitsPasswordGuesses) {
  for (int i = 0; i < 10; ++i) deletion.remove(who, "wrong wrong", "");
  EXPECT_EQ(refusal(deletion.remove(who, password, "")), ProblemKind::kTooManyAttempts);
  EXPECT_THAT(store.removed, IsEmpty());
}

TEST_F(AccountDeletionTest, NotifiesTheUserAndResetsTheLimitsOfTheAddress) {
  ASSERT_TRUE(deletion.remove(who, password, ""));
  ASSERT_EQ(store.mails.size(), 1u);
  EXPECT_EQ(store.mails[0].recipient, who.email);
  const std::string address = "anna@example.org";
  EXPECT_THAT(
      store.attempt_keys,
      UnorderedElementsAre(attempt_key("account", address), attempt_key(kSignUpMails, address),
                           attempt_key(kResetMails, address), attempt_key(kChangeMails, address),
                           attempt_key("change", who.user_id)));
}

TEST_F(AccountDeletionTest, TheSessionsOfTheUserAndOnTheirScansEnd) {
  ASSERT_TRUE(deletion.remove(who, password, ""));
  EXPECT_THAT(placement.ended, ElementsAre("by " + who.user_id, "of a", "of b"));
}

TEST_F(AccountDeletionTest, AnAccountIsDeletedEvenIfItsSessionsCannotBeEnded) {
  placement.break_function("end_all_by");
  ASSERT_TRUE(deletion.remove(who, password, ""));
  EXPECT_THAT(placement.ended, ElementsAre("of a", "of b"));
  EXPECT_EQ(disposals, 1);
  EXPECT_EQ(mails, 1);
}

TEST_F(AccountDeletionTest, NoSessionEndsIfTheAccountStays) {
  expect_unavailable({
      {attempts, "find_by_id", [&] { return refusal(deletion.remove(who, password, "")); }},
      {store, "remove_account", [&] { return refusal(deletion.remove(who, password, "")); }},
  });
  EXPECT_THAT(placement.ended, IsEmpty());
  EXPECT_EQ(disposals + mails, 0);
}

}  // namespace
}  // namespace diaphane::api
