#include "renderd/math/random.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr double kAlpha = 1e-3;

double exact_exponential(std::uint32_t bits) {
  const double v = (bits + 0.5) * 0x1p-32;
  return v > 0.5 ? -std::log1p(-((~bits) + 0.5) * 0x1p-32) : -std::log(v);
}

TEST(Exponential, IsMinusLogWithRelativePrecision) {
  const auto check = [](std::uint32_t bits) {
    const double exact = exact_exponential(bits);
    EXPECT_NEAR(to_exponential(bits), exact, 5e-7 * exact) << bits;
  };
  for (std::uint32_t k = 0; k < 100; ++k) {
    check(k);
    check(~k);
    check(0xc0000000u - 50 + k);
    check(0x80000000u - 50 + k);
  }
  for (std::uint64_t k = 0; k < 1u << 20; ++k) check(static_cast<std::uint32_t>(k * 4093));
}

TEST(Unit, LiesStrictlyBetweenZeroAndOne) {
  EXPECT_GT(to_unit(0), 0.0f);
  EXPECT_LT(to_unit(~0u), 1.0f);
  EXPECT_LT(to_unit(0) * 1e9f,
            1.0f);  // small numbers keep their precision: there is no floor at 2^-24
}

/// Tests the first numbers of the streams of neighbouring pixels, samples and seeds.
TEST(Random, IsUniformAcrossStreams) {
  constexpr int kBins = 101, kNumbers = 1'000'000;
  const double limit = test::critical_chi_square(test::sidak(kAlpha, 3), kBins - 1);
  for (int along = 0; along < 3; ++along) {
    std::array<std::uint64_t, kBins> counts{};
    for (std::uint32_t i = 0; i < kNumbers; ++i) {
      Random random(along == 0 ? i : 7, along == 1 ? i : 5, along == 2 ? i : 3);
      ++counts[static_cast<std::size_t>(random.one() * kBins)];
    }
    EXPECT_LT(test::chi_square_uniform(counts), limit) << "along " << along;
  }
}

TEST(Random, PairsAreUniformOverTheSquare) {
  constexpr int kSide = 32, kNumbers = 2'000'000;
  std::array<std::uint64_t, kSide * kSide> counts{};
  Random random(11, 22, 33);
  for (int i = 0; i < kNumbers; ++i) {
    const Random::Pair u = random.two();
    ++counts[static_cast<std::size_t>(u.a * kSide) * kSide + static_cast<std::size_t>(u.b * kSide)];
  }
  EXPECT_LT(test::chi_square_uniform(counts), test::critical_chi_square(kAlpha, kSide * kSide - 1));
}

TEST(Random, NeighbouringStreamsAreUncorrelated) {
  constexpr int kNumbers = 500'000;
  double by_pixel = 0, by_sample = 0, by_dimension = 0;
  for (std::uint32_t i = 0; i < kNumbers; ++i) {
    Random a(1, i, 0), b(1, i + 1, 0), c(1, i, 1);
    const double x = a.one() - 0.5;
    by_pixel += x * (b.one() - 0.5);
    by_sample += x * (c.one() - 0.5);
    by_dimension += x * (a.one() - 0.5);
  }
  // Each product has mean 0 and variance 1/144.
  const double limit = test::critical_z(test::sidak(kAlpha, 3)) * std::sqrt(kNumbers) / 12;
  EXPECT_LT(std::abs(by_pixel), limit);
  EXPECT_LT(std::abs(by_sample), limit);
  EXPECT_LT(std::abs(by_dimension), limit);
}

TEST(Random, NeighbouringStreamsShareNoNumbers) {
  // In 64 streams of 1024 numbers of 64 bits, a chance collision has probability 1e-10.
  std::set<std::uint64_t> seen;
  for (std::uint32_t key = 0; key < 64; ++key) {
    Random random(key / 16, key / 4 % 4, key % 4);
    for (int i = 0; i < 1024; ++i) EXPECT_TRUE(seen.insert(random.bits()).second);
  }
}

TEST(Random, DependsOnlyOnItsKey) {
  Random a(1, 2, 3), b(1, 2, 3), other(1, 2, 4);
  const std::uint64_t first = a.bits();
  EXPECT_EQ(first, b.bits());
  EXPECT_NE(first, other.bits());
}

}  // namespace
}  // namespace diaphane::render
