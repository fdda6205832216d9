#include "renderd/math/points.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr double kAlpha = 1e-4;  // significance of each test

constexpr std::array kUses{Points::kPixel,       Points::kLens,    Points::kAreaLight,
                           Points::kEnvironment, Points::kScatter, Points::kPick,
                           Points::kDepth};

/// Returns the points of one half; `half` 0 has the even samples.
Points of(std::uint64_t stream, std::uint32_t pixel, std::uint64_t half) {
  return Points(stream, pixel, half);
}

/// Returns the box of edge 2^-k that contains a number, and sets `on_border` if rounding to fp32
/// put the number on a border.
std::uint32_t box_of(float x, std::uint32_t k, bool& on_border) {
  const float scaled = std::ldexp(x, static_cast<int>(k));
  on_border |= k > 0 && scaled == std::floor(scaled);
  return static_cast<std::uint32_t>(scaled);
}

/// In a (0,2)-net, each box of area 2^-m whose edges are powers of two holds one point.
TEST(Points, EveryAlignedBlockIsANet) {
  std::size_t points_seen = 0, on_borders = 0;
  for (const Points::Use use : kUses) {
    for (std::uint32_t half = 0; half < 2; ++half) {
      const Points points = of(9, 1234 + use, half);
      for (std::uint32_t m = 0; m <= 8; ++m) {
        for (const std::uint32_t block : {0u, 1u, 2u, 5u, 1000u}) {
          for (std::uint32_t k = 0; k <= m; ++k) {
            std::set<std::pair<std::uint32_t, std::uint32_t>> boxes;
            std::size_t rounded = 0;
            for (std::uint32_t i = block << m; i < (block + 1) << m; ++i) {
              const Random::Pair p = points.pair(use, i);
              bool on_border = false;
              const std::uint32_t column = box_of(p.a, k, on_border);
              boxes.emplace(column, box_of(p.b, m - k, on_border));
              rounded += on_border;
            }
            ASSERT_GE(boxes.size() + rounded, std::size_t{1} << m)
                << "use " << use << ", half " << half << ", block " << block << ", boxes 2^-" << k;
            points_seen += boxes.size();
            on_borders += rounded;
          }
        }
      }
    }
  }
  EXPECT_LT(on_borders, points_seen / 10'000);
}

TEST(Points, LieInTheOpenUnitSquare) {
  for (std::uint32_t pixel = 0; pixel < 100'000; ++pixel) {
    const Random::Pair p = of(1, pixel, pixel & 1).pair(Points::kDepth, pixel);
    ASSERT_GT(p.a, 0);
    ASSERT_LT(p.a, 1);
    ASSERT_GT(p.b, 0);
    ASSERT_LT(p.b, 1);
  }
}

/// Chi-square of the joint distribution of two numbers over many pixels, against the uniform
/// distribution on the square.
template <typename Numbers>
double chi_square_of(Numbers numbers) {
  constexpr std::uint32_t kSide = 16, kPixels = 256'000;
  std::vector<std::uint64_t> counts(std::size_t{kSide} * kSide);
  for (std::uint32_t pixel = 0; pixel < kPixels; ++pixel) {
    const auto [a, b] = numbers(pixel);
    ++counts[static_cast<std::size_t>(a * kSide) + kSide * static_cast<std::size_t>(b * kSide)];
  }
  return test::chi_square_uniform(counts);
}
constexpr double kBinsLessOne = 255;

TEST(Points, AreUniformWithIndependentCoordinates) {
  constexpr std::array<std::uint32_t, 4> kIndices{0, 1, 7, 100'000};
  const double limit = test::critical_chi_square(
      test::sidak(kAlpha, 2 * kUses.size() * kIndices.size()), kBinsLessOne);
  for (const Points::Use use : kUses) {
    for (std::uint64_t half = 0; half < 2; ++half) {
      for (const std::uint32_t index : kIndices) {
        EXPECT_LT(chi_square_of([&](std::uint32_t pixel) {
                    const Random::Pair p = of(3, pixel, half).pair(use, index);
                    return std::pair(p.a, p.b);
                  }),
                  limit)
            << "use " << use << ", half " << half << ", point " << index;
      }
    }
  }
}

/// The points of different pairs, halves and streams are independent, also at the same index, and
/// in both their first and their second numbers.
TEST(Points, PairsHalvesAndStreamsAreIndependent) {
  std::vector<double> chi;
  for (std::size_t i = 0; i < kUses.size(); ++i) {
    const Points::Use use = kUses[i], other = kUses[(i + 1) % kUses.size()];
    for (const std::uint32_t index : {0u, 5u}) {
      chi.push_back(chi_square_of([&](std::uint32_t pixel) {
        const Points points = of(3, pixel, 0);
        return std::pair(points.pair(use, index).a, points.pair(other, index).a);
      }));
      chi.push_back(chi_square_of([&](std::uint32_t pixel) {
        return std::pair(of(3, pixel, 0).pair(use, index).b, of(3, pixel, 1).pair(use, index).b);
      }));
      chi.push_back(chi_square_of([&](std::uint32_t pixel) {
        return std::pair(of(3, pixel, 0).pair(use, index).a, of(4, pixel, 0).pair(use, index).a);
      }));
      chi.push_back(chi_square_of([&](std::uint32_t pixel) {
        return std::pair(of(3, pixel, 0).pair(use, index).a,
                         of(3, pixel + 1, 0).pair(use, index).a);
      }));
    }
  }
  const double limit = test::critical_chi_square(test::sidak(kAlpha, chi.size()), kBinsLessOne);
  for (std::size_t i = 0; i < chi.size(); ++i) EXPECT_LT(chi[i], limit) << i;
}

/// Pairs are also independent within one sequence. Over n points of a pixel, the product of the
/// numbers of two pairs has mean 0. Its variance is between 1 and 2 times that of independent
/// points (n / 144): a shuffle that keeps every block a net leaves two successive points on
/// opposite sides in both pairs. An integrand of both pairs therefore gains nothing from the net,
/// while an integrand of one pair gains everything.
TEST(Points, PairsOfOnePixelAreShuffledIndependently) {
  constexpr std::uint32_t kPoints = 64, kPixels = 20'000;
  const double limit = test::critical_z(test::sidak(kAlpha, 3 * kUses.size()));
  for (std::size_t i = 0; i < kUses.size(); ++i) {
    const Points::Use use = kUses[i], other = kUses[(i + 3) % kUses.size()];
    test::Moments sum, squared;
    for (std::uint32_t pixel = 0; pixel < kPixels; ++pixel) {
      const Points points = of(8, pixel, 0);
      double product = 0;
      for (std::uint32_t k = 0; k < kPoints; ++k) {
        product += (double{points.pair(use, k).a} - 0.5) * (double{points.pair(other, k).b} - 0.5);
      }
      sum.add(product);
      squared.add(product * product * 144 / kPoints);
    }
    EXPECT_NEAR(sum.mean, 0, limit * sum.error_of_mean()) << use;
    EXPECT_GT(squared.mean, 1 - limit * squared.error_of_mean()) << use;
    EXPECT_LT(squared.mean, 2 + limit * squared.error_of_mean()) << use;
  }
}

/// A smooth integrand over [0, 1]^2 that is not a product of two functions of one variable.
double smooth(double a, double b) { return std::cos(3 * a + 2 * b * b); }
double integral_of_smooth() {
  constexpr int kSteps = 2000;  // midpoint rule: the error is about 1e-7
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) sum += smooth((i + 0.5) / kSteps, (j + 0.5) / kSteps);
  }
  return sum / kSteps / kSteps;
}

struct Halves {
  test::Moments bias;      ///< mean of both halves minus the integral
  test::Moments square;    ///< square of the bias
  test::Moments estimate;  ///< squared half difference of the halves
};
Halves integrate(std::uint32_t per_half) {
  const double exact = integral_of_smooth();
  Halves result;
  for (std::uint32_t pixel = 0; pixel < 8000; ++pixel) {
    double half[2] = {};
    for (std::uint64_t h = 0; h < 2; ++h) {
      const Points points = of(5, pixel, h);
      for (std::uint32_t k = 0; k < per_half; ++k) {
        const Random::Pair p = points.pair(Points::kAreaLight, k);
        half[h] += smooth(double{p.a}, double{p.b}) / per_half;
      }
    }
    const double off = (half[0] + half[1]) / 2 - exact, d = (half[0] - half[1]) / 2;
    result.bias.add(off);
    result.square.add(off * off);
    result.estimate.add(d * d);
  }
  return result;
}

/// The error estimate relies on this law: two halves with separate scrambles are independent
/// estimates, so half their difference has the variance of their mean. This holds even where points
/// are spread so evenly that the variance of single samples says nothing.
TEST(Points, HalfDifferenceHasTheVarianceOfTheMean) {
  for (const std::uint32_t n : {1u, 3u, 8u, 32u, 50u}) {
    const Halves halves = integrate(n);
    const double limit = test::critical_z(test::sidak(kAlpha, 10));
    EXPECT_NEAR(halves.bias.mean, 0, limit * halves.bias.error_of_mean()) << n;
    EXPECT_NEAR(halves.estimate.mean, halves.square.mean,
                limit * std::hypot(halves.estimate.error_of_mean(), halves.square.error_of_mean()))
        << n;
  }
}

TEST(Points, ConvergeFasterThanIndependentPoints) {
  // A nested scrambling of a (0,2)-net converges as n^-1.5 for a smooth function. Independent
  // points have a variance of about 0.19 / n.
  const double few = std::sqrt(integrate(4).square.mean),
               many = std::sqrt(integrate(64).square.mean);
  EXPECT_LT(std::log2(many / few) / 4, -1.2) << "slope from 8 to 128 samples";
  EXPECT_LT(many, 0.1 * std::sqrt(0.19 / 128));
}

TEST(Points, DoNotRepeatAfterTwoToThe33Samples) {
  const std::uint64_t far = std::uint64_t{1} << 33;
  const Random::Pair near_pair = Points(1, 2, 0).pair(Points::kPixel);
  const Random::Pair far_pair = Points(1, 2, far).pair(Points::kPixel);
  EXPECT_TRUE(near_pair.a != far_pair.a && near_pair.b != far_pair.b);
}

}  // namespace
}  // namespace diaphane::render
