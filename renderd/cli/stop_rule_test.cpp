#include "renderd/cli/stop_rule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace diaphane::render::cli {
namespace {

struct Course {
  std::uint64_t samples = 0;
  int looks = 0;
  StopReason reason{};
};

/// A renderer with the error 1 / sqrt(samples) that takes `cost` seconds per sample.
Course follow(const StopRule& rule, double cost) {
  Pace pace(rule);
  Course course;
  for (;;) {
    course.samples += pace.piece();
    pace.advance(course.samples);
    std::optional<double> error;
    if (pace.error_is_due()) {
      ++course.looks;
      error = course.samples < 2 ? std::numeric_limits<double>::infinity()
                                 : 1 / std::sqrt(static_cast<double>(course.samples));
    }
    if (const auto reason = pace.reached(cost * static_cast<double>(course.samples), error)) {
      course.reason = *reason;
      return course;
    }
  }
}

TEST(StopRule, RendersExactlyTheRequestedSamples) {
  for (const std::uint32_t n : {1u, 2u, 3u, 31u, 32u, 33u, 64u, 1000u}) {
    const Course r = follow({.samples = n}, 1);
    EXPECT_EQ(r.samples, n);
    EXPECT_EQ(r.looks, 0);
    EXPECT_EQ(r.reason, StopReason::kSamples);
    EXPECT_EQ(follow({.samples = n, .error = 1e-9}, 1).samples, n);
  }
}

TEST(StopRule, ReachesTheErrorWithFewChecks) {
  for (const double error : {0.5, 0.1, 0.01, 0.001}) {
    const Course r = follow({.error = error}, 1);
    const double needed = 1 / (error * error);
    EXPECT_EQ(r.reason, StopReason::kError);
    EXPECT_GE(static_cast<double>(r.samples), needed * (1 - 1e-9));
    EXPECT_LE(static_cast<double>(r.samples), 1.25 * needed + 1);
    EXPECT_LE(r.looks, 10 + std::log(needed) / std::log(1.25))
        << "the error is checked in a geometric series";
  }
}

TEST(StopRule, StopsAtWhicheverLimitComesFirst) {
  EXPECT_EQ(follow({.samples = 10, .error = 0.01, .seconds = 100}, 1).reason, StopReason::kSamples);
  EXPECT_EQ(follow({.samples = 1000, .error = 0.2, .seconds = 100}, 1).reason, StopReason::kError);
  EXPECT_EQ(follow({.samples = 1000, .error = 0.01, .seconds = 50}, 1).reason,
            StopReason::kSeconds);
}

TEST(StopRule, BeginsWithSmallPassesSoThatTheCurveOfTheErrorBeginsEarly) {
  Pace pace({.samples = 200});
  std::vector<std::uint64_t> passes{0};
  while (passes.back() < 200) {
    passes.push_back(passes.back() + pace.piece());
    pace.advance(passes.back());
  }
  const std::vector<std::uint64_t> expected{0, 2, 4, 8, 16, 32, 64, 96, 128, 160, 192, 200};
  EXPECT_EQ(passes, expected);
}

TEST(StopRule, RendersAtLeastOneSample) {
  const Course r = follow({.seconds = 1e-3}, 60);
  EXPECT_EQ(r.samples, 1u);
  EXPECT_EQ(r.reason, StopReason::kSeconds);
}

}  // namespace
}  // namespace diaphane::render::cli
