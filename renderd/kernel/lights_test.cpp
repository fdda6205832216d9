#include "renderd/kernel/lights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "renderd/math/random.h"
#include "renderd/math/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr double kAlpha = 1e-3;

AreaLight rectangle(Float3 corner, Float3 u, Float3 v) {
  AreaLight light{};
  light.corner = corner;
  light.u = u;
  light.v = v;
  light.normal = normalize(cross(u, v));
  light.area = length(cross(u, v));
  light.radiance = {2, 3, 5};
  light.probability = light.cumulative = 1;
  return light;
}

/// Radiance times the solid angle weighted with nothing: what a point in the open receives from all
/// of the light, by the midpoint rule in double precision.
double received(const AreaLight& light, Double3 place) {
  constexpr int kSteps = 400;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const Double3 to = to_double(light.corner) + to_double(light.u) * ((i + 0.5) / kSteps) +
                         to_double(light.v) * ((j + 0.5) / kSteps) - place;
      const double cosine = -dot(to_double(light.normal), to) / length(to);
      if (cosine > 0) sum += cosine / dot(to, to);
    }
  }
  return sum / (kSteps * kSteps) * light.area;
}

TEST(RectangleLight, SamplesAddUpToItsSolidAngle) {
  const AreaLight light = rectangle({-10, -20, 50}, {0, 30, 0}, {20, 5, -3});
  const Float3 places[] = {{0, 0, 0}, {60, -40, 10}, {0, 0, 44}, {-100, 100, 20}};
  for (const Float3 place : places) {
    test::Moments moments;
    Random random(1, 2, 3);
    for (int i = 0; i < 300'000; ++i) {
      const Random::Pair u = random.two();
      const LightSample s = sample_light(light, place, u.a, u.b);
      moments.add(s.lit ? s.irradiance.y : 0);
    }
    const double exact = 3 * received(light, to_double(place));
    EXPECT_NEAR(moments.mean, exact,
                test::critical_z(test::sidak(kAlpha, 4)) * moments.error_of_mean() + 1e-5 * exact);
  }
}

TEST(RectangleLight, PointsAreUniformOverIt) {
  const AreaLight light = rectangle({-10, -20, 50}, {0, 30, 0}, {20, 5, -3});
  const Double3 place{3, -4, 5}, u = to_double(light.u), v = to_double(light.v);
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), det = uu * vv - uv * uv;
  constexpr int kSide = 10;  // 100 patches
  std::array<std::uint64_t, kSide * kSide> counts{};
  const auto patch = [](double x) { return std::clamp(static_cast<int>(x * kSide), 0, kSide - 1); };
  Random random(4, 5, 6);
  for (int i = 0; i < 1'000'000; ++i) {
    const Random::Pair r = random.two();
    const LightSample s = sample_light(light, to_float(place), r.a, r.b);
    ASSERT_TRUE(s.lit);
    const Double3 p = place + to_double(s.direction) * double{s.distance} - to_double(light.corner);
    const int a = patch((dot(p, u) * vv - dot(p, v) * uv) / det);
    const int b = patch((dot(p, v) * uu - dot(p, u) * uv) / det);
    ++counts[static_cast<std::size_t>(a + kSide * b)];
  }
  EXPECT_LT(test::chi_square_uniform(counts), test::critical_chi_square(kAlpha, kSide * kSide - 1));
}

TEST(RectangleLight, DirectionAndDistanceLeadToIt) {
  const AreaLight light = rectangle({-10, -20, 50}, {0, 30, 0}, {20, 5, -3});
  const LightSample s = sample_light(light, {1, 2, 3}, 0.25f, 0.75f);
  const Float3 reached = Float3{1, 2, 3} + s.direction * s.distance;
  const Float3 point = light.corner + light.u * 0.25f + light.v * 0.75f;
  EXPECT_LT(length(reached - point), 1e-4f);
}

TEST(RectangleLight, ShinesToOneSideOnly) {
  const AreaLight light = rectangle({-10, -10, 50}, {0, 20, 0}, {20, 0, 0});  // downwards
  EXPECT_TRUE(sample_light(light, {0, 0, 0}, 0.5f, 0.5f).lit);
  EXPECT_FALSE(sample_light(light, {0, 0, 100}, 0.5f, 0.5f).lit);
  EXPECT_FALSE(sample_light(light, {500, 0, 50}, 0.5f, 0.5f).lit);  // in its plane
  EXPECT_FALSE(sample_light(light, {0, 0, 50}, 0.5f, 0.5f).lit);    // on it
}

TEST(PickRectangle, FollowsTheProbabilitiesAndLeavesAUniformNumber) {
  const double powers[] = {1, 1000, 1e-3, 40, 0.5, 300, 7};
  double total = 0, sum = 0;
  for (double p : powers) total += p;
  std::vector<AreaLight> lights;
  for (double p : powers) {
    AreaLight light{};
    sum += p / total;
    light.probability = static_cast<float>(p / total);
    light.cumulative = static_cast<float>(sum);
    lights.push_back(light);
  }
  const LightsView view{lights.data(), static_cast<std::uint32_t>(lights.size()), {}};
  constexpr int kSamples = 1'000'000, kBins = 101;
  std::array<std::uint64_t, 7> picked{};
  std::array<std::uint64_t, kBins> stretched{};
  Random random(1, 2, 3);
  for (int i = 0; i < kSamples; ++i) {
    float u = random.one();
    ++picked[pick_light(view, u)];
    ASSERT_GE(u, 0.0f);
    ASSERT_LT(u, 1.0f);
    ++stretched[static_cast<std::size_t>(u * kBins)];
  }
  const double limit = test::critical_z(test::sidak(kAlpha, 8));
  for (std::size_t i = 0; i < picked.size(); ++i) {
    const double p = powers[i] / total;
    EXPECT_NEAR(static_cast<double>(picked[i]), kSamples * p,
                limit * std::sqrt(kSamples * p) + 1 + kSamples * 1e-7)
        << i;
  }
  EXPECT_LT(test::chi_square_uniform(stretched),
            test::critical_chi_square(test::sidak(kAlpha, 8), kBins - 1));
}

}  // namespace
}  // namespace diaphane::render
