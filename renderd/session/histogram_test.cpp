#include "renderd/session/histogram.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace diaphane::render {
namespace {

volume::Volume with_values(std::vector<std::int16_t> voxels) {
  volume::Volume volume;
  volume.voxels = std::move(voxels);
  volume::measure(volume);
  return volume;
}

std::vector<std::uint32_t> counts_of(const volume::Volume& volume) {
  const auto histogram = histogram_of(volume);
  return {histogram.counts().begin(), histogram.counts().end()};
}

TEST(Histogram, CountsEveryVoxelInItsBin) {
  std::vector<std::int16_t> voxels;
  for (int value = -1024; value <= 3071; ++value) {
    voxels.push_back(static_cast<std::int16_t>(value));
  }
  const volume::Volume volume = with_values(voxels);
  EXPECT_EQ(histogram_of(volume).minimum(), -1024);
  EXPECT_EQ(histogram_of(volume).width(), 16);
  EXPECT_EQ(counts_of(volume), std::vector<std::uint32_t>(256, 16));
}

TEST(Histogram, UsesOneBinPerValueForFewValues) {
  const volume::Volume volume = with_values({5, 5, 5, 7, 9});
  EXPECT_EQ(histogram_of(volume).width(), 1);
  EXPECT_EQ(counts_of(volume), (std::vector<std::uint32_t>{3, 0, 1, 0, 1}));
  EXPECT_EQ(counts_of(with_values({4, 4})), std::vector<std::uint32_t>{2});
}

TEST(Histogram, IgnoresValuesOutsideTheMeasuredRange) {
  volume::Volume volume = with_values({0, 1, 2, 3});
  volume.voxels.insert(volume.voxels.end(), {INT16_MIN, INT16_MIN, INT16_MAX});
  EXPECT_EQ(counts_of(volume), std::vector<std::uint32_t>(4, 1));
}

TEST(Histogram, SamplesLargeVolumesProportionally) {
  // Each column of a row of 512 has its own value.
  std::vector<std::int16_t> voxels(std::size_t{512} * 512 * 64);
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    voxels[i] = static_cast<std::int16_t>(i % 512 / 2);
  }
  const auto counts = counts_of(with_values(std::move(voxels)));
  std::uint64_t looked = 0;
  for (const std::uint32_t n : counts) looked += n;
  EXPECT_LE(looked, 4'000'000U);
  EXPECT_GE(looked, 3'000'000U);
  const double fair = static_cast<double>(looked) / 256;
  for (const std::uint32_t n : counts) EXPECT_NEAR(n, fair, fair * 0.01);
}

}  // namespace
}  // namespace diaphane::render
