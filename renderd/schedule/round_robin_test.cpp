#include "renderd/schedule/round_robin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <random>
#include <vector>

namespace diaphane::render {
namespace {

SessionView view(std::uint64_t handle, std::uint64_t samples = 16, double cost = 0.001) {
  SessionView session;
  session.session = handle;
  session.samples = samples;
  session.error = 0.5;
  session.target_error = 0.01;
  session.seconds_per_sample = cost;
  return session;
}

/// Checks that the policy returns one quantum, and returns that.
Quantum next(RoundRobin& policy, const std::vector<SessionView>& sessions) {
  const std::vector<Quantum> round = policy.next(sessions);
  EXPECT_EQ(round.size(), 1U);
  return round.at(0);
}

TEST(RoundRobin, EverySessionRunsOncePerRound) {
  RoundRobin policy;
  std::vector<SessionView> sessions{view(5), view(2), view(9), view(7)};
  std::map<std::uint64_t, int> turns;
  for (int i = 0; i < 40; ++i) ++turns[next(policy, sessions).session];
  ASSERT_EQ(turns.size(), sessions.size());
  for (const auto& [handle, count] : turns) EXPECT_EQ(count, 10) << handle;
}

TEST(RoundRobin, ResultDoesNotDependOnTheSessionOrder) {
  RoundRobin ordered;
  RoundRobin shuffled;
  std::vector<SessionView> sessions{view(1), view(2), view(3), view(4), view(5)};
  std::vector<SessionView> other = sessions;
  std::mt19937 random(1);
  for (int i = 0; i < 50; ++i) {
    std::shuffle(other.begin(), other.end(), random);
    EXPECT_EQ(next(ordered, sessions).session, next(shuffled, other).session);
  }
}

TEST(RoundRobin, SkipsConvergedAndHiddenSessions) {
  RoundRobin policy;
  std::vector<SessionView> sessions{view(1), view(2), view(3)};
  sessions[0].error = 0.01;
  sessions[1].visible = false;
  for (int i = 0; i < 5; ++i) EXPECT_EQ(next(policy, sessions).session, 3U);
  sessions[2].error = 0.005;
  EXPECT_TRUE(policy.next(sessions).empty());
  EXPECT_TRUE(policy.next({}).empty());
}

TEST(RoundRobin, UnknownErrorIsNotConverged) {
  RoundRobin policy;
  std::vector<SessionView> sessions{view(1)};
  sessions[0].error = std::numeric_limits<double>::infinity();
  EXPECT_EQ(policy.next(sessions).size(), 1U);
  sessions[0].error = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(policy.next(sessions).size(), 1U);
}

TEST(RoundRobin, NewSessionWaitsAtMostOneRound) {
  RoundRobin policy;
  std::vector<SessionView> sessions;
  for (std::uint64_t handle = 1; handle <= 20; ++handle) sessions.push_back(view(handle));
  for (int i = 0; i < 7; ++i) policy.next(sessions);
  sessions.push_back(view(21, 0));
  int waited = 0;
  while (next(policy, sessions).session != 21) ++waited;
  EXPECT_LE(waited, 20);
}

}  // namespace
}  // namespace diaphane::render
