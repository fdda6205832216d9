#include "renderd/engine/cuda/row_counts.h"

#include <gtest/gtest.h>

#include <random>

namespace diaphane::render::cuda {
namespace {

TEST(RowCounts, BatchesCoverTheWholeImageUnlessStopped) {
  RowCounts rows(100);
  for (const std::uint64_t target : {1u, 33u, 40u}) {
    while (rows.least() < target) {
      const auto piece = rows.next(target, 32);
      EXPECT_EQ(piece.first_row, 0u);
      EXPECT_EQ(piece.last_row, 100u);
      EXPECT_EQ(piece.film_sample, rows.least());
      rows.done(piece, 100);
      EXPECT_TRUE(rows.flat());
    }
    EXPECT_EQ(rows.least(), target);
  }
}

TEST(RowCounts, StoppedBatchResumesWhereItStopped) {
  RowCounts rows(64);
  rows.done(rows.next(40, 32), 24);
  EXPECT_EQ(rows.least(), 0u);
  EXPECT_EQ(rows.of(23), 32u);
  EXPECT_EQ(rows.of(24), 0u);
  const auto rest = rows.next(40, 32);
  EXPECT_EQ(rest.first_row, 24u);
  EXPECT_EQ(rest.samples, 32u) << "all rows use the same batches, so sums are identical";
  rows.done(rest, 1000);
  EXPECT_TRUE(rows.flat());
  EXPECT_EQ(rows.least(), 32u);
}

/// Whatever is requested and wherever it is stopped, each row gets each sample once and in order.
TEST(RowCounts, EveryRowGetsEverySampleOnce) {
  std::mt19937 random(5);
  for (int round = 0; round < 200; ++round) {
    const std::uint32_t height = 8 * (1 + random() % 20) - random() % 8;
    RowCounts rows(height);
    std::vector<std::uint64_t> has(height);
    std::uint64_t target = 0;
    for (int call = 0; call < 12; ++call) {
      target = rows.least() + 1 + random() % 70;
      for (int launch = static_cast<int>(random() % 6); launch > 0 && rows.least() < target;
           --launch) {
        const auto piece = rows.next(target, 32);
        ASSERT_GT(piece.samples, 0u);
        ASSERT_LE(piece.samples, 32u);
        ASSERT_EQ(piece.first_row % 8, 0u);
        const std::uint32_t count = 8 * (1 + random() % 24);
        for (std::uint32_t y = piece.first_row;
             y < std::min(piece.first_row + count, piece.last_row); ++y) {
          ASSERT_EQ(has[y], piece.film_sample);
          has[y] += piece.samples;
        }
        rows.done(piece, count);
        for (std::uint32_t y = 0; y < height; ++y) ASSERT_EQ(rows.of(y), has[y]);
        ASSERT_EQ(rows.least(), *std::min_element(has.begin(), has.end()));
      }
    }
  }
}

}  // namespace
}  // namespace diaphane::render::cuda
