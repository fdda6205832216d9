#include "operator/kube/lease.h"

#include <gtest/gtest.h>

namespace diaphane::kube {
namespace {

using namespace std::chrono_literals;
using Step = LeaseDecision::Step;
using Time = LeaseDecision::Time;

LeaseRecord held_by(const std::string& holder, const std::string& version) {
  LeaseRecord record;
  record.holder = holder;
  record.version = version;
  return record;
}

LeaseDecision::Options me() {
  LeaseDecision::Options options;
  options.identity = "me";
  return options;
}

TEST(Lease, WaitsUntilTheLeaseWasRead) {
  const LeaseDecision decision(me());
  EXPECT_EQ(decision.step(Time{} + 1h), Step::kWait);
}

TEST(Lease, IsCreatedIfMissing) {
  LeaseDecision decision(me());
  decision.observed(std::nullopt, Time{});
  EXPECT_EQ(decision.step(Time{}), Step::kCreate);
}

TEST(Lease, AcquiresLeaseThatWasUnchangedForItsDurationByLocalClock) {
  LeaseDecision decision(me());
  decision.observed(held_by("other", "1"), Time{});
  EXPECT_EQ(decision.step(Time{} + 14s), Step::kWait);
  decision.observed(held_by("other", "2"), Time{} + 14s);
  EXPECT_EQ(decision.step(Time{} + 16s), Step::kWait);
  decision.observed(held_by("other", "2"), Time{} + 28s);
  EXPECT_EQ(decision.step(Time{} + 28s), Step::kWait);
  EXPECT_EQ(decision.step(Time{} + 29s), Step::kAcquire);
}

TEST(Lease, AcquiresReleasedLeaseAtOnce) {
  LeaseDecision decision(me());
  decision.observed(held_by("", "1"), Time{});
  EXPECT_EQ(decision.step(Time{}), Step::kAcquire);
}

TEST(Lease, RunsFromTheStartOfTheRenewingWrite) {
  LeaseDecision decision(me());
  decision.observed(std::nullopt, Time{});
  decision.written(held_by("me", "1"), Time{} + 1s);
  EXPECT_TRUE(decision.leads(Time{} + 10s));
  EXPECT_FALSE(decision.leads(Time{} + 11s));
  EXPECT_EQ(decision.step(Time{} + 10s), Step::kRenew);
  EXPECT_EQ(decision.step(Time{} + 11s), Step::kLost);
}

TEST(Lease, SuspendedLeaderLosesItsLease) {
  LeaseDecision decision(me());
  decision.written(held_by("me", "1"), Time{});
  EXPECT_FALSE(decision.leads(Time{} + 60s));
  EXPECT_EQ(decision.step(Time{} + 60s), Step::kLost);
}

TEST(Lease, IsLostWhenTakenOrDeleted) {
  LeaseDecision taken(me()), deleted(me());
  for (LeaseDecision* one : {&taken, &deleted}) one->written(held_by("me", "1"), Time{});
  taken.observed(held_by("other", "2"), Time{} + 1s);
  deleted.observed(std::nullopt, Time{} + 1s);
  EXPECT_EQ(taken.step(Time{} + 1s), Step::kLost);
  EXPECT_EQ(deleted.step(Time{} + 1s), Step::kLost);
}

TEST(Lease, RecoversFromLostWriteResponse) {
  LeaseDecision decision(me());
  decision.written(held_by("me", "1"), Time{});
  decision.observed(held_by("me", "2"), Time{} + 2s);
  EXPECT_EQ(decision.step(Time{} + 2s), Step::kRenew);
  EXPECT_EQ(decision.record()->version, "2");
}

TEST(Lease, FollowersRetryWithJitter) {
  LeaseDecision decision(me());
  EXPECT_EQ(decision.pause(0), 2s);
  EXPECT_GT(decision.pause(0.9), 4s);
  decision.written(held_by("me", "1"), Time{});
  EXPECT_EQ(decision.pause(0.9), 2s);
}

// Two candidates with the same record, each with its own clock, one of which stops: they never lead
// at the same time.
TEST(Lease, NeverHasTwoLeadersDespiteClockDifferences) {
  for (int still = 0; still < 40; ++still) {
    LeaseDecision::Options a = me(), b = me();
    a.identity = "a";
    b.identity = "b";
    LeaseDecision first(a), second(b);
    first.written(held_by("a", "1"), Time{} + 1h);
    std::optional<LeaseRecord> record = held_by("a", "1");
    bool second_leads = false;
    for (int t = 0; t < 60; ++t) {
      const Time of_first = Time{} + 1h + std::chrono::seconds(t);
      const Time of_second = Time{} + std::chrono::seconds(t);
      if (t < still && first.step(of_first) == Step::kRenew) {
        record->version = std::to_string(t + 2);
        first.written(*record, of_first);
      }
      if (!second.has_led()) second.observed(record, of_second);
      if (second.step(of_second) == Step::kAcquire) {
        record = held_by("b", "x");
        second.written(*record, of_second);
        second_leads = true;
      }
      EXPECT_FALSE(first.leads(of_first) && second.leads(of_second)) << still << " " << t;
    }
    EXPECT_TRUE(second_leads);
  }
}

}  // namespace
}  // namespace diaphane::kube
