#include "renderd/schedule/error_proportional.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace diaphane::render {
namespace {

SessionView view(std::uint64_t handle, std::uint64_t samples) {
  SessionView session;
  session.session = handle;
  session.samples = samples;
  session.error = 0.5;
  session.target_error = 0.01;
  session.seconds_per_sample = 0.001;
  return session;
}

/// Pearson's chi-squared over 200,000 draws; 16.27 is its 99.9% quantile at 3 degrees of freedom.
TEST(ErrorProportional, ProbabilityIsInverseToTheRootOfIterations) {
  ErrorProportional policy({}, 7);
  const std::vector<SessionView> sessions{view(3, 1), view(11, 4), view(12, 100), view(40, 2500)};
  std::map<std::uint64_t, double> turns;
  constexpr int kDraws = 200'000;
  for (int i = 0; i < kDraws; ++i) ++turns[policy.next(sessions).at(0).session];
  const double all = 1 + 1.0 / 2 + 1.0 / 10 + 1.0 / 50;
  double chi = 0;
  for (const SessionView& session : sessions) {
    const double expected = kDraws / std::sqrt(double(session.samples)) / all;
    chi += std::pow(turns[session.session] - expected, 2) / expected;
  }
  EXPECT_LT(chi, 16.27);
}

TEST(ErrorProportional, NewImageCountsAsOneIteration) {
  ErrorProportional policy;
  const std::vector<SessionView> sessions{view(1, 0), view(2, 1)};
  int first = 0;
  for (int i = 0; i < 10'000; ++i) first += policy.next(sessions).at(0).session == 1;
  EXPECT_NEAR(first, 5000, 200);  // four standard deviations
}

TEST(ErrorProportional, OtherSeedDrawsDifferently) {
  ErrorProportional one({}, 1);
  ErrorProportional two({}, 2);
  const std::vector<SessionView> sessions{view(1, 1), view(2, 1), view(3, 1)};
  int equal = 0;
  for (int i = 0; i < 3000; ++i)
    equal += one.next(sessions).at(0).session == two.next(sessions).at(0).session;
  EXPECT_NEAR(equal, 1000, 110);
}

}  // namespace
}  // namespace diaphane::render
