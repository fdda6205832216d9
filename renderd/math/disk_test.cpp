#include "renderd/math/disk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "renderd/math/random.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

/// Chi-square of 1e6 points over 101 rings of equal area, over 101 sectors, and over 8 x 13 cells
/// of both. The significance is 1e-3 over the three tests (Sidak).
TEST(Disk, SamplesAreUniformOverRingsAndSectors) {
  constexpr int kSamples = 1'000'000, kBins = 101;
  std::array<std::uint64_t, kBins> rings{}, sectors{};
  std::array<std::uint64_t, 104> both{};
  Random random(17, 0, 0);
  for (int i = 0; i < kSamples; ++i) {
    const Random::Pair u = random.two();
    const DiskPoint p = sample_disk(u.a, u.b);
    const double x = static_cast<double>(p.x), y = static_cast<double>(p.y);
    const double area = x * x + y * y;
    const double turn = std::atan2(y, x) / (2 * std::numbers::pi) + 0.5;
    ASSERT_LE(area, 1 + 1e-6);
    const auto bin = [](double v, int bins) {
      return static_cast<std::size_t>(std::min(static_cast<int>(v * bins), bins - 1));
    };
    ++rings[bin(area, kBins)];
    ++sectors[bin(turn, kBins)];
    ++both[13 * bin(area, 8) + bin(turn, 13)];
  }
  const double alpha = test::sidak(1e-3, 3);
  EXPECT_LT(test::chi_square_uniform(rings), test::critical_chi_square(alpha, kBins - 1));
  EXPECT_LT(test::chi_square_uniform(sectors), test::critical_chi_square(alpha, kBins - 1));
  EXPECT_LT(test::chi_square_uniform(both), test::critical_chi_square(alpha, 103));
}

TEST(Disk, MapsCornersEdgesAndCentreIntoTheDisk) {
  for (const float u : {0.0f, 0.5f, 1.0f, 0x1.fffffep-1f}) {
    for (const float v : {0.0f, 0.5f, 1.0f, 0x1p-33f}) {
      const DiskPoint p = sample_disk(u, v);
      EXPECT_LE(p.x * p.x + p.y * p.y, 1 + 1e-6f) << u << " " << v;
    }
  }
  EXPECT_EQ(sample_disk(0.5f, 0.5f).x, 0);
}

}  // namespace
}  // namespace diaphane::render
