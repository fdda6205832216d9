#include "renderd/serve/expected_load.h"

#include <gtest/gtest.h>

#include <vector>

namespace diaphane::render {
namespace {

using Usage = ExpectedLoad::Usage;

double after_seconds(ExpectedLoad& load, int seconds, double busy, std::vector<Usage> sessions,
                     const std::vector<double>& took, std::size_t slots = 10) {
  double value = 0;
  for (int i = 0; i < seconds; ++i) {
    for (std::size_t k = 0; k < sessions.size(); ++k) sessions[k].device_seconds += took[k];
    value = load.after(1, busy, sessions, slots);
  }
  return value;
}

/// An unknown session counts as a tenth. After a long time at one rate, the memory's 600 s weigh
/// against the prior's 30 s. Steps of a second change less than 0.001.
double settled(double prior, double rate) { return (30 * prior + 600 * rate) / 630; }
constexpr double kStep = 0.001;

TEST(ExpectedLoad, IsZeroForAnEmptyWorker) { EXPECT_EQ(ExpectedLoad().after(1, 0, {}, 4), 0); }

TEST(ExpectedLoad, AssumesASlotShareForUnknownSessions) {
  ExpectedLoad load;
  EXPECT_NEAR(load.after(0, 0, std::vector<Usage>{{"a"}, {"b"}}, 8), 2.0 / 8, 1e-12);
}

TEST(ExpectedLoad, FollowsTheObservedLoad) {
  ExpectedLoad load;
  // The posterior after n seconds at a rate r is (30 p + n r) / (30 + n), with slight forgetting.
  EXPECT_NEAR(after_seconds(load, 60, 0.5, {{"a"}}, {0.5}), (30 * 0.1 + 60 * 0.5) / 90, 0.01);
  EXPECT_NEAR(after_seconds(load, 9000, 0.5, {{"a", 30}}, {0.5}), settled(0.1, 0.5), kStep);
}

TEST(ExpectedLoad, IdleSessionsDecayButStayAboveZero) {
  ExpectedLoad load;
  const double soon = after_seconds(load, 60, 0, {{"a"}}, {0});
  const double late = after_seconds(load, 6000, 0, {{"a"}}, {0});
  EXPECT_LT(soon, 0.1 / 2);
  EXPECT_LT(late, soon);
  EXPECT_GT(late, 0.1 * 30 / 700) << "it may come back";
}

TEST(ExpectedLoad, ForgetsOldObservations) {
  ExpectedLoad load;
  after_seconds(load, 600, 1, {{"a"}}, {1});
  EXPECT_LT(after_seconds(load, 3000, 0, {{"a", 600}}, {0}), 0.05);
}

TEST(ExpectedLoad, SubtractsSessionsThatLeft) {
  ExpectedLoad load;
  after_seconds(load, 300, 1, {{"a"}, {"b"}}, {0.9, 0.1});
  const double both = load.after(0, 0, std::vector<Usage>{{"a", 270}, {"b", 30}}, 10);
  const double one = load.after(0, 0, std::vector<Usage>{{"b", 30}}, 10);
  EXPECT_NEAR(both - one, (30 * 0.1 + 300 * 0.9) / 330, 0.03);
}

TEST(ExpectedLoad, ConcurrentWorkCountsOnce) {
  ExpectedLoad load;
  EXPECT_NEAR(after_seconds(load, 9000, 1, {{"a"}, {"b"}}, {1, 1}), 2 * settled(0.1, 0.5), kStep);
  EXPECT_NEAR(load.after(0, 0, std::vector<Usage>{{"b", 9000}}, 10), settled(0.1, 0.5), kStep);
}

TEST(ExpectedLoad, IncludesVideosAndImagesForOtherWorkers) {
  ExpectedLoad load;
  EXPECT_NEAR(after_seconds(load, 9000, 0.8, {{"a"}}, {0.2}), settled(0.1, 0.2) + settled(0, 0.6),
              kStep);
  EXPECT_NEAR(after_seconds(load, 9000, 0.8, {}, {}), settled(0, 0.8), kStep);
}

TEST(ExpectedLoad, IgnoresClockThatStopsOrGoesBack) {
  ExpectedLoad load;
  load.after(1, 0.5, std::vector<Usage>{{"a", 0.5}}, 4);
  const double before = load.after(0, 0, std::vector<Usage>{{"a", 0.5}}, 4);
  EXPECT_EQ(load.after(-3, 7, std::vector<Usage>{{"a", 0.1}}, 4), before);
}

}  // namespace
}  // namespace diaphane::render
