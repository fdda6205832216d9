#include "renderd/session/convergence.h"

#include <gtest/gtest.h>

#include <limits>

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;

const TimePoint kStart{100s};

TEST(ConvergenceTest, MeasuresTheTimeFromTheInputToFivePercentOncePerView) {
  Convergence convergence;
  convergence.began(kStart, kStart);
  EXPECT_FALSE(convergence.progressed({8, 0.5, 0.051}, false, kStart + 1s).seconds_to_five_percent);
  const auto measured = convergence.progressed({16, 1, 0.05}, false, kStart + 2s);
  ASSERT_TRUE(measured.seconds_to_five_percent);
  EXPECT_DOUBLE_EQ(*measured.seconds_to_five_percent, 2);
  EXPECT_FALSE(convergence.progressed({32, 2, 0.03}, false, kStart + 3s).seconds_to_five_percent);
  convergence.began(kStart + 10s, kStart + 10s);
  EXPECT_TRUE(convergence.progressed({64, 1, 0.01}, false, kStart + 11s).seconds_to_five_percent);
}

TEST(ConvergenceTest, TheFirstViewOfASessionCountsFromItsBeginning) {
  Convergence convergence;
  convergence.began(TimePoint{}, kStart);
  EXPECT_EQ(convergence.progressed({8, 0.5, 0.04}, false, kStart + 3s).seconds_to_five_percent, 3);
}

TEST(ConvergenceTest, MeasuresTheLastErrorOfAViewAtRestWhenItEnds) {
  Convergence convergence;
  EXPECT_FALSE(convergence.began(kStart, kStart).error_at_rest);
  convergence.progressed({8, 0.5, 0.2}, false, kStart);
  convergence.progressed({16, 1, 0.1}, false, kStart);
  EXPECT_EQ(convergence.began(kStart, kStart).error_at_rest, 0.1);
  convergence.progressed({8, 0.5, 0.3}, false, kStart);
  EXPECT_EQ(convergence.ended().error_at_rest, 0.3);
  EXPECT_FALSE(convergence.ended().error_at_rest) << "counted once";
}

TEST(ConvergenceTest, PicturesOfAGestureCountOnlyInTheCurve) {
  Convergence convergence;
  convergence.began(kStart, kStart);
  const auto measured = convergence.progressed({8, 0.5, 0.01}, true, kStart + 1s);
  EXPECT_FALSE(measured.seconds_to_five_percent);
  EXPECT_EQ(convergence.curve().points().size(), 1u);
  EXPECT_FALSE(convergence.began(kStart, kStart).error_at_rest);
}

TEST(ConvergenceTest, TheCurveIsThatOfTheCurrentView) {
  Convergence convergence;
  convergence.began(kStart, kStart);
  convergence.progressed({1, 0.1, std::numeric_limits<double>::infinity()}, false, kStart);
  convergence.progressed({2, 0.2, 0.5}, false, kStart);
  convergence.began(kStart, kStart);
  convergence.progressed({4, 0.3, 0.4}, false, kStart);
  const v1::ErrorCurve curve = to_proto(convergence.curve(), 7);
  EXPECT_EQ(curve.epoch(), 7u);
  ASSERT_EQ(curve.points_size(), 1);
  EXPECT_EQ(curve.points(0).samples(), 4u);
  EXPECT_DOUBLE_EQ(curve.points(0).seconds(), 0.3);
  EXPECT_DOUBLE_EQ(curve.points(0).error(), 0.4);
}

}  // namespace
}  // namespace diaphane::render
