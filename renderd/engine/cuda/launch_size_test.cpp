#include "renderd/engine/cuda/launch_size.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace diaphane::render::cuda {
namespace {

TEST(LaunchSize, ConvergesToTheTargetTimeForAnyCost) {
  for (const double ms_per_sample : {1e-9, 1e-6, 1e-3, 1.0}) {
    LaunchSize size;
    for (int i = 0; i < 30; ++i) {
      size.learn(size.work(), static_cast<double>(size.work()) * ms_per_sample);
    }
    const double ms = static_cast<double>(size.work()) * ms_per_sample;
    EXPECT_LE(ms, 1.01 * LaunchSize::kTargetMs);
    EXPECT_GE(ms, 0.5 * LaunchSize::kTargetMs);
  }
}

TEST(LaunchSize, GrowsAtMostFourfoldAndShrinksImmediately) {
  LaunchSize size;
  const std::uint64_t first = size.work();
  size.learn(first, 0);
  EXPECT_EQ(size.work(), 4 * first);
  size.learn(4 * first, 8000);
  EXPECT_EQ(size.work(), 4 * first / 1000);
  size.forget();
  EXPECT_EQ(size.work(), first);
  size.forget(64);
  EXPECT_EQ(size.work(), first / 64) << "launches for long paths start small";
  size.forget(1e300);
  EXPECT_EQ(size.work(), 1u);
}

/// A picture of 2048 x 2048 pixels. Its upper half is empty and its lower half is dense, with paths
/// of a thousand collisions, where the device takes 1e-3 ms per sample.
TEST(LaunchSize, EmptyRowsDoNotMakeLaunchesOfDenseRowsTooLong) {
  constexpr std::uint64_t kHalf = 2048 * 1024;
  LaunchSize size;
  size.forget(1024, 2 * kHalf, 1024);
  double longest = 0;
  int launches = 0;
  for (int turn = 0; turn < 3; ++turn) {
    for (std::uint64_t done = 0; done < 2 * kHalf; ++launches) {
      const std::uint64_t work = size.work();
      const double ms = 0.01 + (done >= kHalf ? 1e-3 * static_cast<double>(work) : 0.0);
      longest = std::max(longest, ms);
      size.learn(work, ms);
      done += work;
    }
  }
  EXPECT_LE(longest, 5 * LaunchSize::kTargetMs);
  EXPECT_LE(launches, 3 * 600) << "shorter launches than 1/8 ms do not pay off";
}

/// The picture of the test above with 16 samples per pixel, so its work is 16 times as large.
TEST(LaunchSize, PassEndsAfterAllSamplesOfItsPixels) {
  constexpr std::uint64_t kPixels = 2048 * 2048;
  constexpr std::uint32_t kSamples = 16;
  LaunchSize size;
  size.forget(1024, kPixels, 1024);
  // All rows so far are background, so the limit of the first pass still holds.
  const std::uint64_t background = kPixels * kSamples / 2;
  for (std::uint64_t done = 0; done < background;) {
    const std::uint64_t work = std::min(size.work(), background - done);
    size.learn(work, 0.01, kSamples);
    done += work;
  }
  const std::uint64_t limit = size.work();
  EXPECT_LE(limit, 1u << 14);
  for (std::uint64_t done = background; done < 2 * background;) {
    const std::uint64_t work = std::min(size.work(), 2 * background - done);
    size.learn(work, 0.01, kSamples);
    done += work;
  }
  size.learn(size.work(), 0.01, kSamples);
  EXPECT_GT(size.work(), limit) << "the whole picture was rendered once";
}

TEST(LaunchSize, RowsAreAPositiveMultipleOfTheStep) {
  LaunchSize size;
  size.learn(size.work(), 1e12);
  EXPECT_EQ(size.rows(8192, 16, 8), 8u);
  size.forget();
  EXPECT_EQ(size.rows(512, 16, 8), 32u);
  EXPECT_EQ(size.rows(1, 1, 8), 65536u);
}

TEST(LaneShift, GivesEachSampleAThreadUpToTheMaximum) {
  EXPECT_EQ(lane_shift_for(1, 5), 0u);
  EXPECT_EQ(lane_shift_for(3, 5), 1u);
  EXPECT_EQ(lane_shift_for(16, 5), 4u);
  EXPECT_EQ(lane_shift_for(31, 5), 4u);
  EXPECT_EQ(lane_shift_for(1000, 5), 5u);
}

}  // namespace
}  // namespace diaphane::render::cuda
