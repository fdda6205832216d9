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

TEST(RoundRobin, EverySessionHasOneTurnInEveryRound) {
  RoundRobin policy;
  std::vector<SessionView> sessions{view(5), view(2), view(9), view(7)};
  std::map<std::uint64_t, int> turns;
  for (int i = 0; i < 40; ++i) ++turns[policy.next(sessions)->session];
  ASSERT_EQ(turns.size(), sessions.size());
  for (const auto& [handle, count] : turns) EXPECT_EQ(count, 10) << handle;
}

TEST(RoundRobin, TheOrderInWhichSessionsAreListedChangesNothing) {
  RoundRobin ordered;
  RoundRobin shuffled;
  std::vector<SessionView> sessions{view(1), view(2), view(3), view(4), view(5)};
  std::vector<SessionView> other = sessions;
  std::mt19937 random(1);
  for (int i = 0; i < 50; ++i) {
    std::shuffle(other.begin(), other.end(), random);
    EXPECT_EQ(ordered.next(sessions)->session, shuffled.next(other)->session);
  }
}

TEST(RoundRobin, ConvergedAndHiddenSessionsGetNothing) {
  RoundRobin policy;
  std::vector<SessionView> sessions{view(1), view(2), view(3)};
  sessions[0].error = 0.01;
  sessions[1].visible = false;
  for (int i = 0; i < 5; ++i) EXPECT_EQ(policy.next(sessions)->session, 3U);
  sessions[2].error = 0.005;
  EXPECT_FALSE(policy.next(sessions).has_value());
  EXPECT_FALSE(policy.next({}).has_value());
}

TEST(RoundRobin, AnUnknownErrorIsNotConverged) {
  RoundRobin policy;
  std::vector<SessionView> sessions{view(1)};
  sessions[0].error = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(policy.next(sessions).has_value());
  sessions[0].error = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(policy.next(sessions).has_value());
}

TEST(RoundRobin, AQuantumFitsItsTimeAndNeverMoreThanDoublesTheSamples) {
  RoundRobin policy;
  for (const std::uint64_t samples : {0, 1, 2, 3, 10, 1000, 1 << 20}) {
    for (const double cost : {0.0, 1e-6, 1e-4, 0.002, 0.029, 0.031, 3.0}) {
      const std::vector<SessionView> sessions{view(1, samples, cost)};
      const std::uint32_t quantum = policy.next(sessions)->samples;
      EXPECT_GE(quantum, 1U);
      if (samples > 0) {
        EXPECT_LE(quantum, samples);
      }
      EXPECT_LE(quantum, 1024U);
      if (quantum > 1) {
        EXPECT_LE(quantum * cost, (samples == 0 ? 0.008 : 0.03) + 1e-9);
      }
    }
  }
}

TEST(RoundRobin, ANewSessionWaitsAtMostOneRound) {
  RoundRobin policy;
  std::vector<SessionView> sessions;
  for (std::uint64_t handle = 1; handle <= 20; ++handle) sessions.push_back(view(handle));
  for (int i = 0; i < 7; ++i) policy.next(sessions);
  sessions.push_back(view(21, 0));
  int waited = 0;
  while (policy.next(sessions)->session != 21) ++waited;
  EXPECT_LE(waited, 20);
}

}  // namespace
}  // namespace diaphane::render
