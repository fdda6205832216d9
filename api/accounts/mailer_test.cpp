#include "api/accounts/mailer.h"

#include <gtest/gtest.h>

#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;

class Queue final : public MailStore {
 public:
  Result<std::optional<Queued>> claim_mail(Time now, std::chrono::seconds lease) override {
    if (done || not_before > now) return std::nullopt;
    not_before = now + lease;
    return Queued{1, attempts, {"a@b", "s", "b"}};
  }
  Result<void> mail_sent(std::int64_t) override {
    done = true;
    return {};
  }
  Result<void> mail_failed(std::int64_t, Time when) override {
    ++attempts;
    not_before = when;
    return {};
  }
  bool done = false;
  int attempts = 0;
  Time not_before;
};

class Transport final : public MailTransport {
 public:
  Result<void> send(const Mail&) override {
    ++calls;
    if (calls <= failures) return fail(code, "no");
    return {};
  }
  ErrorCode code = ErrorCode::kUnavailable;
  int failures = 0, calls = 0;
};

TEST(Mailer, RetriesWithBackoffUntilSent) {
  Queue queue;
  Transport transport;
  transport.failures = 3;
  ManualClock clock;
  Mailer mailer(queue, transport, clock);
  auto waited = 0s;
  while (!queue.done && waited < 1h) {
    mailer.send_due();
    clock.advance(1s);
    waited += 1s;
  }
  EXPECT_EQ(transport.calls, 4);
  EXPECT_GE(waited, 5s + 10s + 20s);
}

TEST(Mailer, GivesUpAfterPermanentErrorOrTooManyAttempts) {
  Queue refused_for_good, always_failing;
  Transport transport;
  transport.failures = 1000;
  ManualClock clock;
  transport.code = ErrorCode::kInvalid;
  Mailer(refused_for_good, transport, clock).send_due();
  EXPECT_TRUE(refused_for_good.done);
  transport.code = ErrorCode::kUnavailable;
  for (int i = 0; i < 12; ++i) {
    Mailer(always_failing, transport, clock).send_due();
    clock.advance(2h);
  }
  EXPECT_TRUE(always_failing.done);
}

TEST(Mailer, BackoffDoublesUpToOneHour) {
  EXPECT_EQ(Mailer::pause_after(1), 5s);
  EXPECT_EQ(Mailer::pause_after(2), 10s);
  EXPECT_EQ(Mailer::pause_after(100), 1h);
}

/// A queue of emails that are all due. Each is leased as it is claimed.
class FakeMailStore final : public MailStore, public Fake {
 public:
  int due = 0, sent = 0, failed = 0;
  std::chrono::seconds lease{0};

  Result<std::optional<Queued>> claim_mail(Time, std::chrono::seconds time) override {
    DIAPHANE_TRY(enter("claim_mail"));
    lease = time;
    if (due == 0) return std::nullopt;
    --due;
    return Queued{1, 0, {"a@b", "subject", "body"}};
  }
  Result<void> mail_sent(std::int64_t) override {
    ++sent;
    return {};
  }
  Result<void> mail_failed(std::int64_t, Time) override {
    ++failed;
    return {};
  }
};

class FakeTransport final : public MailTransport, public Fake {
 public:
  Result<void> send(const Mail&) override { return enter("send"); }
};

TEST(MailerTest, PollSendsAtMostTwentyEmails) {
  FakeMailStore store;
  FakeTransport transport;
  const ManualClock clock;
  Mailer mailer(store, transport, clock);
  store.due = 25;
  EXPECT_EQ(mailer.send_due().sent, 20);
  EXPECT_EQ(mailer.send_due().sent, 5);
  EXPECT_EQ(store.sent, 25);
  EXPECT_EQ(store.lease, 2min) << "longer than a server may take to accept it";
}

TEST(MailerTest, OneFailureDoesNotHoldUpTheOthers) {
  FakeMailStore store;
  FakeTransport transport;
  const ManualClock clock;
  Mailer mailer(store, transport, clock);
  store.due = 3;
  transport.before("send", [&] {
    transport.repair("send");
    if (transport.calls("send") == 1) transport.break_function("send");
  });
  const auto total = mailer.send_due();
  EXPECT_EQ(total.failed, 1);
  EXPECT_EQ(total.sent, 2);
  EXPECT_EQ(store.failed, 1);
  EXPECT_EQ(store.sent, 2);
  store.due = 1;
  store.break_function("claim_mail");
  EXPECT_EQ(mailer.send_due().sent, 0);
}

}  // namespace
}  // namespace diaphane::api
