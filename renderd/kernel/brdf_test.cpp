#include "renderd/kernel/brdf.h"

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
const std::uint64_t kSamples = test::gate_or_nightly(100'000, 1'000'000);

Float3 grey(double x) {
  const auto f = static_cast<float>(x);
  return {f, f, f};
}

/// A surface whose normal is along no axis, with the viewer at the given cosine.
Brdf surface(double diffuse, double specular, double roughness, double cosine) {
  const Float3 n = normalize(Float3{0.3f, -0.5f, 0.8f});
  Float3 s, t;
  basis_around(n, s, t);
  const auto c = static_cast<float>(cosine);
  const Float3 viewer =
      n * c + (s * 0.6f + t * 0.8f) * static_cast<float>(std::sqrt(1 - cosine * cosine));
  return {n, viewer, grey(diffuse), grey(specular), static_cast<float>(roughness)};
}

Float3 mirrored(const Brdf& b) {
  return normalize(b.normal * (2 * dot(b.normal, b.viewer)) - b.viewer);
}

/// Bins in the logarithm of 1 - cos around the mirror direction, where a narrow lobe is, down to
/// the resolution of fp32 directions.
constexpr double kLeastLog = -20;
double log_width() { return (std::log(2.0) - kLeastLog) / kBins; }

struct Probabilities {
  std::array<double, kBins> polar{}, azimuth{};
};

/// Integrates brdf_density() by the midpoint rule.
Probabilities integrated(const Brdf& b) {
  constexpr int kSub = 24, kAround = kBins * 12;
  const Float3 pole = mirrored(b);
  Float3 s, t;
  basis_around(pole, s, t);
  Probabilities p;
  for (int i = 0; i < kBins * kSub; ++i) {
    const double log_c = kLeastLog + (i + 0.5) * log_width() / kSub;
    const double c = std::exp(log_c);
    const double sine = std::sqrt(c * (2 - c));
    // d(1 - cos) = c d(log c); the first bin reaches down to 0.
    const double ring = c * log_width() / kSub * 2 * std::numbers::pi / kAround;
    for (int k = 0; k < kAround; ++k) {
      const double angle = ((k + 0.5) / kAround * 2 - 1) * std::numbers::pi;
      const Float3 d = s * static_cast<float>(sine * std::cos(angle)) +
                       t * static_cast<float>(sine * std::sin(angle)) +
                       pole * static_cast<float>(1 - c);
      const double part = brdf_density<true>(b, d) * ring;
      p.polar[static_cast<std::size_t>(i / kSub)] += part;
      p.azimuth[static_cast<std::size_t>(k * kBins / kAround)] += part;
    }
  }
  return p;
}

struct Setting {
  double diffuse, specular, roughness, cosine;
};
constexpr Setting kSettings[] = {
    {0.8, 0, 0.5, 0.6},    {0, 1, 0.3, 1},        {0, 1, 1, 0.5},   {0.9, 0.04, 0.09, 0.8},
    {0.5, 0.3, 0.01, 0.4}, {0.7, 0.2, 0.4, 0.05}, {1, 1, 0.2, 0.3}, {0.2, 0.9, 0.6, 0.9},
};

TEST(Brdf, SamplerMatchesItsDensity) {
  const double alpha = test::sidak(kAlpha, 2 * std::size(kSettings));
  for (const Setting& setting : kSettings) {
    const Brdf b = surface(setting.diffuse, setting.specular, setting.roughness, setting.cosine);
    const Float3 pole = mirrored(b);
    Float3 s, t;
    basis_around(pole, s, t);
    std::array<std::uint64_t, kBins> polar{}, azimuth{};
    Random random(1, 2, 3);
    for (std::uint64_t i = 0; i < kSamples; ++i) {
      const Random::Pair u = random.two();
      const Float3 d = sample_brdf<true>(b, u.a, u.b);
      ASSERT_NEAR(length(d), 1, 1e-5);
      if (!(brdf_density<true>(b, d) > 0)) continue;  // below the surface
      const Double3 off = to_double(d) - to_double(pole);
      const double c = std::max(0.5 * dot(off, off), std::exp(kLeastLog));
      const auto bin = static_cast<int>((std::log(c) - kLeastLog) / log_width());
      ++polar[static_cast<std::size_t>(std::min(bin, kBins - 1))];
      const double angle = std::atan2(dot(d, t), dot(d, s)) / (2 * std::numbers::pi) + 0.5;
      ++azimuth[static_cast<std::size_t>(std::min(angle, 0.9999999) * kBins)];
    }
    const Probabilities p = integrated(b);
    const std::string what = std::to_string(setting.specular) + " rough " +
                             std::to_string(setting.roughness) + " at " +
                             std::to_string(setting.cosine);
    EXPECT_TRUE(test::chi_square(polar, p.polar, static_cast<double>(kSamples)).fits(alpha))
        << what;
    EXPECT_TRUE(test::chi_square(azimuth, p.azimuth, static_cast<double>(kSamples)).fits(alpha))
        << what;
  }
}

/// The mean weight of the sampler is the fraction of uniform light that is reflected.
test::Moments reflected(const Brdf& b, std::uint64_t samples) {
  test::Moments m;
  Random random(4, 5, 6);
  for (std::uint64_t i = 0; i < samples; ++i) {
    const Random::Pair u = random.two();
    const Float3 d = sample_brdf<true>(b, u.a, u.b);
    const float density = brdf_density<true>(b, d);
    m.add(density > 0 ? evaluate_brdf<true>(b, d).x / density : 0);
  }
  return m;
}

/// White furnace test of a surface. Nothing is lost without a lobe, and at most 1% under a smooth
/// one. A rough one loses the light that its facets would scatter a second time.
TEST(Brdf, ConservesEnergyWithLittleLoss) {
  int settings = 0;
  for (double specular : {0.0, 0.001, 0.02, 0.04, 0.2, 0.6, 1.0}) {
    for (double roughness : {0.001, 0.05, 0.2, 0.5, 1.0}) {
      for (double cosine : {1.0, 0.8, 0.5, 0.2, 0.05}) {
        const test::Moments m = reflected(surface(1, specular, roughness, cosine), 20'000);
        const double noise = test::critical_z(kAlpha / 175) * m.error_of_mean();
        EXPECT_LE(m.mean, 1 + noise + 1e-5) << specular << " " << roughness << " " << cosine;
        if (cosine >= 0.5) {
          const double kept = specular == 0 ? 1 - 1e-4 : 0.99 - 0.72 * roughness;
          EXPECT_GE(m.mean, kept - noise) << specular << " " << roughness << " " << cosine;
        }
        ++settings;
      }
    }
  }
  EXPECT_EQ(settings, 175);
}

/// Helmholtz reciprocity.
TEST(Brdf, IsReciprocal) {
  Random random(7, 8, 9);
  for (const Setting& setting : kSettings) {
    for (int i = 0; i < 1000; ++i) {
      Brdf b = surface(setting.diffuse, setting.specular, setting.roughness, setting.cosine);
      const Random::Pair u = random.two();
      Brdf lambert = b;
      lambert.specular = {};
      const Float3 light = sample_brdf<true>(lambert, u.a, u.b);
      const double there = evaluate_brdf<true>(b, light).x / dot(b.normal, light);
      const double in = dot(b.normal, b.viewer);
      const Float3 viewer = b.viewer;
      b.viewer = light;
      const double back = evaluate_brdf<true>(b, viewer).x / in;
      EXPECT_NEAR(there, back, 2e-3 * back + 1e-6) << setting.roughness;
    }
  }
}

TEST(Brdf, BlackLobeEqualsNoLobe) {
  const Brdf b = surface(0.7, 0, 0.3, 0.5);
  Random random(1, 1, 1);
  for (int i = 0; i < 1000; ++i) {
    const Random::Pair u = random.two();
    const Float3 d = sample_sphere(u.a, u.b);
    ASSERT_EQ(evaluate_brdf<true>(b, d).x, evaluate_brdf<false>(b, d).x);
    ASSERT_EQ(brdf_density<true>(b, d), brdf_density<false>(b, d));
    const Float3 p = sample_brdf<true>(b, u.a, u.b), q = sample_brdf<false>(b, u.a, u.b);
    ASSERT_EQ(p.x, q.x);
    ASSERT_EQ(p.z, q.z);
  }
}

/// Extreme cases: directions along the surface, mirror-like lobes, numbers at the ends of their
/// ranges.
TEST(Brdf, StaysFinite) {
  for (double roughness : {1e-3, 0.5, 1.0}) {
    for (double cosine : {1.0, 0.5, 1e-4, 1e-8}) {
      const Brdf b = surface(1, 0.5, roughness, cosine);
      for (float u : {1e-9f, 0.3f, 0.7f, 0x1.fffffep-1f}) {
        for (float v : {1e-9f, 0.5f, 0x1.fffffep-1f}) {
          const Float3 d = sample_brdf<true>(b, u, v);
          ASSERT_TRUE(is_finite(d));
          ASSERT_TRUE(std::isfinite(brdf_density<true>(b, d)));
          ASSERT_TRUE(is_finite(evaluate_brdf<true>(b, d)));
        }
      }
    }
  }
}

}  // namespace
}  // namespace diaphane::render
