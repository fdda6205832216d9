#include "renderd/schedule/emission.h"

#include <gtest/gtest.h>

namespace diaphane::render {
namespace {

EmissionInput shown(std::uint64_t samples, std::uint64_t shown, double seconds = 0.05) {
  EmissionInput q;
  q.samples = samples;
  q.samples_shown = shown;
  q.seconds_since_frame = seconds;
  return q;
}

TEST(Emission, ShowsTheFirstSampleImmediatelyEvenWithoutRoom) {
  EmissionInput q = shown(1, 0);
  q.room = false;
  EXPECT_TRUE(should_emit(q));
  EXPECT_FALSE(should_emit(shown(0, 0)));
}

TEST(Emission, ShowsOneImagePerDoublingAtRest) {
  int pictures = 0;
  std::uint64_t last = 0;
  for (std::uint64_t samples = 1; samples <= 1024; ++samples) {
    if (!should_emit(shown(samples, last))) continue;
    last = samples;
    ++pictures;
  }
  EXPECT_EQ(pictures, 11);  // 1, 2, 4 ... 1024
}

TEST(Emission, LimitsTheRateOfRefinements) {
  EXPECT_FALSE(should_emit(shown(64, 1, 0.01)));
  EXPECT_TRUE(should_emit(shown(64, 1, 0.04)));
  EXPECT_TRUE(should_emit(shown(1, 0, 0.0))) << "a new epoch's first picture never waits";
}

TEST(Emission, ShowsAnImageEveryFewHundredMillisecondsWhileMoving) {
  EmissionInput q = shown(101, 100, 0.2);
  EXPECT_FALSE(should_emit(q));
  q.moving = true;
  EXPECT_TRUE(should_emit(q));
  q.seconds_since_frame = 0.05;
  EXPECT_FALSE(should_emit(q));
}

TEST(Emission, ShowsTheImageOnceInFullQualityAtRest) {
  EmissionInput q = shown(40, 40);
  q.shown_moving = true;
  EXPECT_TRUE(should_emit(q));
  q.moving = true;
  EXPECT_FALSE(should_emit(q));
  q.moving = false;
  q.shown_moving = false;
  EXPECT_FALSE(should_emit(q));
}

TEST(Emission, AlwaysShowsTheConvergedImage) {
  EmissionInput q = shown(130, 128);
  q.room = false;
  EXPECT_FALSE(should_emit(q));
  q.converged = true;
  EXPECT_TRUE(should_emit(q));
  q.samples_shown = 130;
  EXPECT_FALSE(should_emit(q));
}

TEST(Emission, SendsNoRefinementsWithoutRoom) {
  EmissionInput q = shown(64, 16, 10);
  EXPECT_TRUE(should_emit(q));
  q.room = false;
  EXPECT_FALSE(should_emit(q));
}

TEST(Emission, ShowsOneImagePerSecondDuringLongDoublings) {
  EXPECT_FALSE(should_emit(shown(1500, 1024, 0.9)));
  EXPECT_TRUE(should_emit(shown(1500, 1024, 1.1)));
  EXPECT_FALSE(should_emit(shown(1100, 1024, 1.1)));
}

/// After the last input the viewer waits for the first picture whose error is known, and then sees
/// refinements sooner than during a drag.
TEST(Emission, ShowsTheSecondImageEarlierWithoutInput) {
  EmissionInput q = shown(2, 1, 0.001);
  EXPECT_FALSE(should_emit(q)) << "more input is expected, so a new image follows soon";
  q.seconds_since_input = 0.03;
  EXPECT_TRUE(should_emit(q));
  q = shown(8, 4, 0.015);
  EXPECT_FALSE(should_emit(q));
  q.seconds_since_input = 0.03;
  EXPECT_TRUE(should_emit(q));
  q.seconds_since_frame = 0.005;
  EXPECT_FALSE(should_emit(q));
}

}  // namespace
}  // namespace diaphane::render
