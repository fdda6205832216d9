#include "renderd/schedule/policy.h"

#include <gtest/gtest.h>

#include <limits>

namespace diaphane::render {
namespace {

TEST(Policies, AreFoundByName) {
  for (const PolicyKind kind : kPolicyKinds) {
    EXPECT_EQ(policy_kind(policy_name(kind)), kind);
    EXPECT_NE(make_policy(kind), nullptr);
  }
  EXPECT_FALSE(policy_kind("marginal_gain"));
  EXPECT_FALSE(policy_kind(""));
}

TEST(Policies, UnknownErrorIsNotConverged) {
  SessionView session;
  session.target_error = 0.01;
  session.error = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(gains(session));
  session.error = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(gains(session));
  session.error = 0.01;
  EXPECT_FALSE(gains(session));
}

TEST(Quanta, AreLongerWithoutRecentInput) {
  SessionView still, moving;
  still.seconds_since_input = 10;
  moving.seconds_since_input = 0.1;
  const QuantumLimits limits;
  EXPECT_GT(limits_for(std::vector{still, still}, limits).quantum_seconds, limits.quantum_seconds);
  SessionView spare = still;
  spare.spare = true;
  EXPECT_EQ(limits_for(std::vector{still, spare}, limits).quantum_seconds, limits.quantum_seconds);
  spare.visible = false;
  EXPECT_GT(limits_for(std::vector{still, spare}, limits).quantum_seconds, limits.quantum_seconds);
  EXPECT_EQ(limits_for(std::vector{still, moving}, limits).quantum_seconds, limits.quantum_seconds);
  moving.visible = false;
  EXPECT_GT(limits_for(std::vector{still, moving}, limits).quantum_seconds, limits.quantum_seconds);
}

TEST(Quanta, FitTheTimeLimitAndAtMostDoubleTheSamples) {
  const QuantumLimits limits;
  for (const std::uint64_t samples : {0, 1, 2, 3, 10, 1000, 1 << 20}) {
    for (const double cost : {0.0, 1e-6, 1e-4, 0.0007, 0.002, 0.009, 0.011, 3.0}) {
      SessionView session;
      session.samples = samples;
      session.seconds_per_sample = cost;
      const std::uint32_t quantum = quantum_samples(session, limits);
      EXPECT_GE(quantum, 1U);
      EXPECT_LE(quantum, limits.max_samples);
      if (quantum == 1) continue;
      EXPECT_LE(quantum * cost,
                (samples == 0 ? limits.first_seconds : limits.quantum_seconds) + 1e-9);
      if (samples > 0 && quantum > samples) {
        EXPECT_LE(quantum * cost, limits.least_seconds + 1e-9) << samples << " " << cost;
      }
    }
  }
}

}  // namespace
}  // namespace diaphane::render
