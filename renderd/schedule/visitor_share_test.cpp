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

/// Returns the device time per session, in seconds, after many decisions over constant views.
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

TEST(VisitorShare, LimitsManyVisitorsToTheirShare) {
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

TEST(VisitorShare, VisitorsGetTheWholeDeviceWithoutAccountHolders) {
  VisitorShare policy = policy_of(PolicyKind::kRoundRobin, 0.25);
  SessionView done = gaining(1, false);
  done.error = 0;
  const auto spent = spend(policy, {done, gaining(2, true), gaining(3, true)});
  EXPECT_FALSE(spent.contains(1));
  EXPECT_NEAR(spent.at(2), spent.at(3), 0.1 * spent.at(3));
  EXPECT_EQ(policy.credit(), 0) << "that time does not count";
}

TEST(VisitorShare, VisitorsAreNotStarvedWithinTheirShare) {
  VisitorShare policy = policy_of(PolicyKind::kRoundRobin, 0.25);
  std::vector<SessionView> views{gaining(1, true)};
  for (std::uint64_t i = 2; i < 10; ++i) views.push_back(gaining(i, false));
  const auto spent = spend(policy, views);
  EXPECT_GT(spent.at(1), 0);
  EXPECT_NEAR(spent.at(1), spent.at(2), 0.2 * spent.at(2)) << "one of nine is below the share";
}

TEST(VisitorShare, VisitorPaysBackALongSampleBeforeTheNext) {
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
        if (paid++ > 0) EXPECT_GE(since, 0.85);  // three times the cost of the quantum
        since = 0;
      }
    }
  }
  EXPECT_GT(paid, 2);
}

TEST(VisitorShare, OvertakingCountsTowardsTheSameShare) {
  VisitorShare policy = policy_of(PolicyKind::kMarginalGain, 0.25);
  const auto dragging = [](std::uint64_t session, bool visitor) {
    SessionView view = gaining(session, visitor);
    view.samples = 0;
    view.seconds_since_input = view.seconds_unanswered = 0.02;
    view.seconds_since_begun = 1;
    return view;
  };
  SessionView holder = gaining(1, false);
  holder.under_way = true;
  int visitors = 0;
  for (int i = 0; i < 1000; ++i) {
    visitors +=
        static_cast<int>(policy.overtaking(std::vector{holder, dragging(2, true)}, 0).size());
  }
  EXPECT_LE(visitors, 8) << "only the saved credit, because no account holder earns more";
  EXPECT_EQ(policy.overtaking(std::vector{holder, dragging(3, false)}, 0).size(), 1U);
}

TEST(VisitorShare, ZeroShareStopsVisitorsWhileOthersGain) {
  VisitorShare policy = policy_of(PolicyKind::kMarginalGain, 0);
  const auto spent = spend(policy, {gaining(1, false), gaining(2, true)});
  EXPECT_LE(spent.contains(2) ? spent.at(2) : 0, 0.02) << "one quantum at most, before any is owed";
}

}  // namespace
}  // namespace diaphane::render
