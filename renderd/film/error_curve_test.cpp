#include "renderd/film/error_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace diaphane::render {
namespace {

ErrorPoint pass(std::uint64_t samples) {
  const auto n = static_cast<double>(samples);
  return {samples, n * 1e-3, 1 / std::sqrt(n)};
}

TEST(ErrorCurveTest, KeepsTheFirstAndTheLastPassAndStepsOfFivePercent) {
  ErrorCurve curve;
  for (std::uint64_t n = 1; n <= 100'000; ++n) curve.add(pass(n));
  const auto& points = curve.points();
  EXPECT_EQ(points.front().samples, 1u);
  EXPECT_EQ(points.back().samples, 100'000u);
  EXPECT_LT(points.size(), 250u);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const double step =
        static_cast<double>(points[i].samples) / static_cast<double>(points[i - 1].samples);
    EXPECT_GE(points[i].samples, points[i - 1].samples + 1);
    EXPECT_LE(step, points[i].samples < 40 ? 2 : 1.08);
  }
}

TEST(ErrorCurveTest, KeepsEveryPassOfAShortRun) {
  ErrorCurve curve;
  for (const std::uint64_t n : {2, 4, 8, 16, 32, 64}) curve.add(pass(n));
  EXPECT_EQ(curve.points().size(), 6u);
}

TEST(ErrorCurveTest, IgnoresUnknownErrorsAndPassesWithoutSamples) {
  ErrorCurve curve;
  curve.add({1, 0.1, std::numeric_limits<double>::infinity()});
  curve.add(pass(2));
  curve.add({2, 0.5, 0.9});
  ASSERT_EQ(curve.points().size(), 1u);
  EXPECT_DOUBLE_EQ(curve.points()[0].seconds, 0.002);
  curve.clear();
  EXPECT_TRUE(curve.points().empty());
}

}  // namespace
}  // namespace diaphane::render
