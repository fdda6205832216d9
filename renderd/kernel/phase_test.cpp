#include "renderd/kernel/phase.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "renderd/math/random.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr double kAlpha = 1e-3;
constexpr int kBins = 101;
const int kSamples = test::gate_or_nightly(100'000, 1'000'000);

/// Probability that 1 - cos is at most `c`, for g >= 0, in double precision and without
/// cancellation.
double cumulative(double g, double c) {
  if (g == 0) return c / 2;
  const double o = 1 - g;
  const double root = std::sqrt(o * o + 2 * g * c);
  // (1 - g^2)/(2g) (1/o - 1/root), with 1/o - 1/root = 2gc / (o root (root + o)).
  return (1 + g) * c / (root * (root + o));
}

TEST(HenyeyGreenstein, SamplerMatchesItsDistribution) {
  const double gs[] = {0, 1e-6, 0.3, -0.3, 0.9, -0.9, 0.99, -0.999};
  const double limit = test::critical_chi_square(test::sidak(kAlpha, 2 * std::size(gs)), kBins - 1);
  const Float3 in = normalize(Float3{0.3f, -0.5f, 0.8f});
  Float3 s, t;
  basis_around(in, s, t);
  for (double g : gs) {
    std::array<std::uint64_t, kBins> polar{}, azimuth{};
    Random random(1, 2, 3);
    for (int i = 0; i < kSamples; ++i) {
      const Random::Pair u = random.two();
      const Float3 out = sample_henyey_greenstein(static_cast<float>(g), in, u.a, u.b);
      // Computed from the distance of the end points, which is exact near the forward direction,
      // unlike 1 - dot.
      const Float3 d = g < 0 ? out + in : out - in;
      const double c = std::min(0.5 * dot(to_double(d), to_double(d)), 2.0);
      const double q = std::min(cumulative(std::abs(g), c), 0.9999999);
      ++polar[static_cast<std::size_t>(q * kBins)];
      const double angle = std::atan2(dot(out, t), dot(out, s)) / (2 * std::numbers::pi) + 0.5;
      ++azimuth[static_cast<std::size_t>(std::min(angle, 0.9999999) * kBins)];
    }
    EXPECT_LT(test::chi_square_uniform(polar), limit) << "polar, g " << g;
    EXPECT_LT(test::chi_square_uniform(azimuth), limit) << "azimuth, g " << g;
  }
}

TEST(HenyeyGreenstein, SamplerInvertsTheDistributionForEveryG) {
  for (double g : {0.0, 0.5, 0.999, 0.9999999, 1 - 0x1p-24}) {
    for (double u : {1e-9, 1e-4, 0.2, 0.5, 0.9, 0.9999}) {
      const double c = sample_one_minus_cos(static_cast<float>(g), static_cast<float>(u));
      EXPECT_GE(c, 0);
      // u = 0 is backward, u = 1 forward.
      EXPECT_NEAR(1 - cumulative(static_cast<float>(g), c), static_cast<float>(u), 2e-6)
          << g << " " << u;
    }
  }
}

TEST(HenyeyGreenstein, DensityIsTheDerivativeOfTheDistribution) {
  for (double g : {-0.9999, -0.7, 0.0, 0.2, 0.95, 0.99999}) {
    for (double angle : {1e-3, 0.1, 1.0, 2.0, 3.1}) {
      const Float3 in{0, 0, 1};
      const Float3 out{static_cast<float>(std::sin(angle)), 0, static_cast<float>(std::cos(angle))};
      const double gf = static_cast<float>(g);
      const double c = 0.5 * (out.x * double{out.x} + (out.z - 1.0) * (out.z - 1.0));
      const double o = (1 - gf) * (1 - gf) + 2 * gf * c;
      const double exact = (1 - gf * gf) / (4 * std::numbers::pi * o * std::sqrt(o));
      EXPECT_NEAR(henyey_greenstein(static_cast<float>(g), in, out), exact, 2e-3 * exact)
          << g << " " << angle;
    }
  }
}

TEST(HenyeyGreenstein, StaysFiniteForTheLargestG) {
  const float g = 0x1.fffffep-1f;
  const Float3 in{0, 0, 1}, back{0, 0, -1};
  for (float sign : {1.0f, -1.0f}) {
    EXPECT_TRUE(std::isfinite(henyey_greenstein(sign * g, in, in)));
    EXPECT_TRUE(std::isfinite(henyey_greenstein(sign * g, in, back)));
    for (float u : {0.0f, 1e-8f, 0.5f, 1.0f}) {
      const Float3 out = sample_henyey_greenstein(sign * g, in, u, 0.3f);
      EXPECT_TRUE(is_finite(out));
      EXPECT_NEAR(length(out), 1.0f, 1e-4f);
    }
  }
}

TEST(Sphere, DirectionsAreUniform) {
  std::array<std::uint64_t, kBins> height{}, azimuth{};
  Random random(4, 5, 6);
  for (int i = 0; i < kSamples; ++i) {
    const Random::Pair u = random.two();
    const Float3 d = sample_sphere(u.a, u.b);
    ASSERT_NEAR(length(d), 1.0f, 1e-5f);
    ++height[static_cast<std::size_t>(std::min((d.z + 1.0) / 2, 0.9999999) * kBins)];
    const double angle = std::atan2(d.y, d.x) / (2 * std::numbers::pi) + 0.5;
    ++azimuth[static_cast<std::size_t>(std::min(angle, 0.9999999) * kBins)];
  }
  const double limit = test::critical_chi_square(test::sidak(kAlpha, 2), kBins - 1);
  EXPECT_LT(test::chi_square_uniform(height), limit);
  EXPECT_LT(test::chi_square_uniform(azimuth), limit);
}

}  // namespace
}  // namespace diaphane::render
