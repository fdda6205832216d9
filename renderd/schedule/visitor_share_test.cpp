#include "renderd/schedule/visitor_share.h"

#include <gtest/gtest.h>

#include <map>

namespace diaphane::render {
namespace {

SessionView gaining(std::uint64_t session, bool visitor) {
  SessionView view;
  view.session = session;
  view.visitor = visitor;
  view.samples = 8;
  view.error = 0.5;
  view.target_error = 0.01;
  view.seconds_per_sample = 0.002;
  return view;
}

/// Seconds of the device by session after many decisions over views that do not change.
std::map<std::uint64_t, double> spend(VisitorShare& policy, const std::vector<SessionView>& views) {
  std::map<std::uint64_t, double> spent;
  for (int i = 0; i < 4000; ++i) {
    for (const Quantum& quantum : policy.next(views)) {
      spent[quantum.session] += quantum.samples * 0.002;
    }
  }
  return spent;
}

VisitorShare policy_of(PolicyKind kind, double share) { return {make_policy(kind), share}; }

TEST(VisitorShare, ManyVisitorsTogetherTakeNoMoreThanTheirShareFromOneAccountHolder) {
  for (const PolicyKind kind : kPolicyKinds) {
    VisitorShare policy = policy_of(kind, 0.25);
    std::vector<SessionView> views{gaining(1, false)};
    for (std::uint64_t i = 2; i < 10; ++i) views.push_back(gaining(i, true));
    const auto spent = spend(policy, views);
    double all = 0;
    for (const auto& [session, seconds] : spent) all += seconds;
    EXPECT_GE(spent.at(1), 0.74 * all) << policy_name(kind);
  }
}

TEST(VisitorShare, VisitorsHaveTheWholeDeviceWhileNoAccountHolderGains) {
  VisitorShare policy = policy_of(PolicyKind::kRoundRobin, 0.25);
  SessionView done = gaining(1, false);
  done.error = 0;
  const auto spent = spend(policy, {done, gaining(2, true), gaining(3, true)});
  EXPECT_FALSE(spent.contains(1));
  EXPECT_NEAR(spent.at(2), spent.at(3), 0.1 * spent.at(3));
  EXPECT_EQ(policy.credit(), 0) << "what they took then is not held against them";
}

TEST(VisitorShare, VisitorsAreNotStarvedWithinTheirShare) {
  VisitorShare policy = policy_of(PolicyKind::kRoundRobin, 0.25);
  std::vector<SessionView> views{gaining(1, true)};
  for (std::uint64_t i = 2; i < 10; ++i) views.push_back(gaining(i, false));
  const auto spent = spend(policy, views);
  EXPECT_GT(spent.at(1), 0);
  EXPECT_NEAR(spent.at(1), spent.at(2), 0.2 * spent.at(2)) << "one of nine is below the share";
}

TEST(VisitorShare, ALongSampleOfAVisitorIsPaidBackBeforeTheNext) {
  VisitorShare policy = policy_of(PolicyKind::kRoundRobin, 0.25);
  SessionView slow = gaining(1, true);
  slow.seconds_per_sample = 0.3;
  const SessionView holder = gaining(2, false);
  double since = 0;
  int paid = 0;
  for (int i = 0; i < 4000; ++i) {
    for (const Quantum& quantum : policy.next(std::vector{slow, holder})) {
      if (quantum.session == 2) {
        since += quantum.samples * 0.002;
      } else {
        if (paid++ > 0) EXPECT_GE(since, 0.85);  // 3 times as long
        since = 0;
      }
    }
  }
  EXPECT_GT(paid, 2);
}

TEST(VisitorShare, NobodyWithoutAnAccountGainsWithAShareOfNothingWhileOthersDo) {
  VisitorShare policy = policy_of(PolicyKind::kMarginalGain, 0);
  const auto spent = spend(policy, {gaining(1, false), gaining(2, true)});
  EXPECT_LE(spent.contains(2) ? spent.at(2) : 0, 0.02) << "one quantum at most, before any is owed";
}

}  // namespace
}  // namespace diaphane::render
