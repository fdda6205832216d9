#include "renderd/kernel/lights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "renderd/math/random.h"
#include "tests/support/renderd/test_lights.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr double kAlpha = 1e-3;
constexpr int kBins = 101;
const int kSamples = test::gate_or_nightly(100'000, 1'000'000);
constexpr Features kPlain{};
constexpr Features kShaped = Features{}.with(Feature::kShapedLights);
constexpr Features kTextured = kShaped.with(Feature::kTexturedLights);

using test::disk;
using test::rectangle;
using test::sphere;

template <Features F>
LightSample sampled(const AreaLight& light, Float3 place, float u, float v) {
  return sample_light<F>(LightsView{}, light, place, u, v);
}

/// A histogram of a number in [0, 1).
class Counts {
 public:
  void add(double x) { ++counts_[static_cast<std::size_t>(std::clamp(x, 0.0, 1 - 1e-9) * kBins)]; }
  bool uniform(double alpha) const {
    return test::chi_square_uniform(counts_) < test::critical_chi_square(alpha, kBins - 1);
  }

 private:
  std::array<std::uint64_t, kBins> counts_{};
};

/// Returns the green light that a point in empty space receives from a parallelogram or a disk, by
/// the midpoint rule in double precision.
double received(const AreaLight& light, Double3 place) {
  constexpr int kSteps = 600;
  const bool round = light.shape == LightShape::kDisk;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      double a = (i + 0.5) / kSteps, b = (j + 0.5) / kSteps;
      if (round) {
        const double r = std::sqrt(a), turn = 2 * std::numbers::pi * b;
        a = r * std::cos(turn);
        b = r * std::sin(turn);
      }
      const Double3 to =
          to_double(light.corner) + to_double(light.u) * a + to_double(light.v) * b - place;
      const double cosine = -dot(to_double(light.normal), to) / length(to);
      if (cosine > 0) sum += cosine / dot(to, to);
    }
  }
  return 3 * sum / (kSteps * kSteps) * static_cast<double>(light.area);
}

/// The solid angle of a sphere.
double sphere_received(const AreaLight& light, Double3 place) {
  const Double3 to = to_double(light.corner) - place;
  const Double3 radius = to_double(light.u);
  const double sine2 = dot(radius, radius) / dot(to, to);
  return 3 * 2 * std::numbers::pi * (sine2 / (1 + std::sqrt(1 - sine2)));
}

struct Case {
  AreaLight light;
  Float3 place;
};
std::vector<Case> cases() {
  const AreaLight lamp = rectangle({-10, -20, 50}, {0, 30, 0}, {20, 5, -3});
  const AreaLight plate = disk({5, -3, 40}, {0.3f, -0.2f, -1}, 12);
  const AreaLight ball = sphere({10, 20, 30}, 9);
  return {{lamp, {0, 0, 0}},       {lamp, {60, -40, 10}}, {lamp, {0, 0, 44}},
          {lamp, {-100, 100, 20}}, {plate, {0, 0, 0}},    {plate, {4, -2, 36}},
          {plate, {-90, 30, 20}},  {ball, {0, 0, 0}},     {ball, {10, 20, 39.01f}},
          {ball, {-4000, 900, 70}}};
}

double exact(const Case& c) {
  return c.light.shape == LightShape::kSphere ? sphere_received(c.light, to_double(c.place))
                                              : received(c.light, to_double(c.place));
}

TEST(AreaLights, SamplesIntegrateToTheSolidAngle) {
  for (const Case& c : cases()) {
    test::Moments moments;
    Random random(1, 2, 3);
    for (int i = 0; i < kSamples; ++i) {
      const Random::Pair u = random.two();
      const LightSample s = sampled<kShaped>(c.light, c.place, u.a, u.b);
      moments.add(s.lit ? static_cast<double>(s.irradiance.y) : 0);
    }
    const double truth = exact(c);
    EXPECT_NEAR(moments.mean, truth,
                test::critical_z(test::sidak(kAlpha, cases().size())) * moments.error_of_mean() +
                    2e-5 * truth);
  }
}

/// Rays in all directions estimate the same integral where they meet the light.
TEST(AreaLights, RandomRaysHitWithTheirSolidAngle) {
  for (const Case& c : cases()) {
    if (exact(c) < 1e-2) continue;  // too small for random rays to meet
    test::Moments moments;
    Random random(7, 2, 3);
    for (int i = 0; i < kSamples; ++i) {
      const Random::Pair u = random.two();
      const LightHit hit =
          meet_light<kShaped>(LightsView{}, c.light, c.place, sample_sphere(u.a, u.b));
      moments.add(hit.met ? static_cast<double>(hit.radiance.y) * 4 * std::numbers::pi : 0);
    }
    EXPECT_NEAR(moments.mean, exact(c),
                test::critical_z(test::sidak(kAlpha, cases().size())) * moments.error_of_mean());
  }
}

/// Sampling a point of a light and intersecting a ray with it agree on its position and density.
TEST(AreaLights, SamplingAndIntersectionAgreeOnTheDensity) {
  for (const Case& c : cases()) {
    Random random(3, 2, 1);
    int missed = 0;
    for (int i = 0; i < 10'000; ++i) {
      const Random::Pair u = random.two();
      const LightSample s = sampled<kShaped>(c.light, c.place, u.a, u.b);
      if (!s.lit) continue;
      const LightHit hit = meet_light<kShaped>(LightsView{}, c.light, c.place, s.direction);
      if (!hit.met) {
        ++missed;  // exactly at the edge
        continue;
      }
      // Rounding moves the distance at which a ray grazes a sphere by the square root of the
      // rounding error.
      const float slack = c.light.shape == LightShape::kSphere ? 2e-2f : 1e-4f;
      ASSERT_NEAR(hit.distance, s.distance, slack * s.distance);
      ASSERT_NEAR(hit.density, s.density, 2e-3f * s.density);
      ASSERT_NEAR(s.irradiance.y * s.density, 3.0f, 1e-4f);
      ASSERT_EQ(hit.radiance.y, 3.0f);
    }
    EXPECT_LT(missed, 30);
  }
}

TEST(RectangleLight, SamplesAreUniform) {
  const AreaLight light = rectangle({-10, -20, 50}, {0, 30, 0}, {20, 5, -3});
  const Double3 place{3, -4, 5}, u = to_double(light.u), v = to_double(light.v);
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), det = uu * vv - uv * uv;
  Counts across, down;
  Random random(4, 5, 6);
  for (int i = 0; i < kSamples; ++i) {
    const Random::Pair r = random.two();
    const LightSample s = sampled<kPlain>(light, to_float(place), r.a, r.b);
    ASSERT_TRUE(s.lit);
    const Double3 p = place + to_double(s.direction) * double{s.distance} - to_double(light.corner);
    across.add((dot(p, u) * vv - dot(p, v) * uv) / det);
    down.add((dot(p, v) * uu - dot(p, u) * uv) / det);
  }
  EXPECT_TRUE(across.uniform(test::sidak(kAlpha, 2)));
  EXPECT_TRUE(down.uniform(test::sidak(kAlpha, 2)));
}

TEST(DiskLight, SamplesAreUniform) {
  const AreaLight light = disk({5, -3, 40}, {0.3f, -0.2f, -1}, 12);
  const Double3 place{3, -4, 5};
  Counts rings, sectors;
  Random random(4, 5, 6);
  for (int i = 0; i < kSamples; ++i) {
    const Random::Pair r = random.two();
    const LightSample s = sampled<kShaped>(light, to_float(place), r.a, r.b);
    ASSERT_TRUE(s.lit);
    const Double3 p = place + to_double(s.direction) * double{s.distance} - to_double(light.corner);
    const double a = dot(p, to_double(light.u)) / 144, b = dot(p, to_double(light.v)) / 144;
    rings.add(a * a + b * b);
    sectors.add(0.5 + std::atan2(a, b) / (2 * std::numbers::pi));
  }
  EXPECT_TRUE(rings.uniform(test::sidak(kAlpha, 2)));
  EXPECT_TRUE(sectors.uniform(test::sidak(kAlpha, 2)));
}

TEST(SphereLight, SampledDirectionsAreUniformOverItsCone) {
  const AreaLight light = sphere({10, 20, 30}, 9);
  for (const Float3 place : {Float3{0, 0, 0}, Float3{10, 20, 39.1f}, Float3{-200, 20, 30}}) {
    const Double3 to = to_double(light.corner - place);
    const double sine2 = 81 / dot(to, to);
    const double most = sine2 / (1 + std::sqrt(1 - sine2));
    Float3 x, y;
    const Float3 axis = to_float(normalize(to));
    basis_around(axis, x, y);
    Counts polar, turn;
    Random random(4, 5, 6);
    for (int i = 0; i < kSamples; ++i) {
      const Random::Pair r = random.two();
      const LightSample s = sampled<kShaped>(light, place, r.a, r.b);
      ASSERT_TRUE(s.lit);
      const Double3 off = to_double(s.direction) - to_double(axis);
      polar.add(0.5 * dot(off, off) / most);
      turn.add(0.5 + std::atan2(static_cast<double>(dot(s.direction, x)),
                                static_cast<double>(dot(s.direction, y))) /
                         (2 * std::numbers::pi));
    }
    EXPECT_TRUE(polar.uniform(test::sidak(kAlpha, 6)));
    EXPECT_TRUE(turn.uniform(test::sidak(kAlpha, 6)));
  }
}

TEST(SphereLight, IsDarkInside) {
  const AreaLight light = sphere({10, 20, 30}, 9);
  for (const Float3 place : {Float3{10, 20, 30}, Float3{10, 20, 38.9f}, Float3{10, 20, 39}}) {
    EXPECT_FALSE(sampled<kShaped>(light, place, 0.3f, 0.6f).lit);
    EXPECT_FALSE(meet_light<kShaped>(LightsView{}, light, place, {0, 0, 1}).met);
  }
}

/// Points are the limit of small lights of equal strength.
TEST(PointLight, EqualsTheLimitOfSmallLights) {
  const Float3 place{3, 5, -40};
  for (const bool round : {false, true}) {
    const auto make = [&](float radius) {
      return round ? sphere({0, 0, 0}, radius) : disk({0, 0, 0}, {0, 0.3f, -1}, radius);
    };
    AreaLight small = make(1e-3f);
    small.radiance = small.radiance * (1 / small.area);
    const LightSample limit = sampled<kShaped>(small, place, 0.4f, 0.7f);
    const LightSample point = sampled<kShaped>(make(0), place, 0.4f, 0.7f);
    ASSERT_TRUE(point.lit);
    EXPECT_NEAR(point.irradiance.y, limit.irradiance.y, 1e-4f * limit.irradiance.y);
    EXPECT_NEAR(point.distance, limit.distance, 2e-3f);
    EXPECT_EQ(point.density, kDeltaDensity);
    EXPECT_FALSE(meet_light<kShaped>(LightsView{}, make(0), place, point.direction).met);
  }
}

TEST(RectangleLight, DirectionAndDistanceLeadToTheSample) {
  const AreaLight light = rectangle({-10, -20, 50}, {0, 30, 0}, {20, 5, -3});
  const LightSample s = sampled<kPlain>(light, {1, 2, 3}, 0.25f, 0.75f);
  const Float3 reached = Float3{1, 2, 3} + s.direction * s.distance;
  const Float3 point = light.corner + light.u * 0.25f + light.v * 0.75f;
  EXPECT_LT(length(reached - point), 1e-4f);
}

TEST(AreaLights, ShineToOneSideOnly) {
  const AreaLight lights[] = {rectangle({-10, -10, 50}, {0, 20, 0}, {20, 0, 0}),
                              disk({0, 0, 50}, {0, 0, -1}, 10)};
  for (const AreaLight& light : lights) {
    const auto lit = [&light](Float3 place) {
      return sampled<kShaped>(light, place, 0.5f, 0.5f).lit;
    };
    EXPECT_TRUE(lit({0, 0, 0}));
    EXPECT_FALSE(lit({0, 0, 100}));
    EXPECT_FALSE(lit({500, 0, 50})) << "in its plane";
    EXPECT_FALSE(lit({0, 0, 50})) << "on it";
    const auto met = [&light](Float3 place, Float3 direction) {
      return meet_light<kShaped>(LightsView{}, light, place, direction).met;
    };
    EXPECT_TRUE(met({0, 0, 0}, {0, 0, 1}));
    EXPECT_FALSE(met({0, 0, 0}, {0, 0, -1}));
    EXPECT_FALSE(met({0, 0, 100}, {0, 0, -1}));
    EXPECT_FALSE(met({11, 0, 0}, {0, 0, 1})) << "beside it";
    EXPECT_FALSE(met({500, 0, 50}, {-1, 0, 0})) << "in its plane";
  }
}

/// A picture of 4 x 2 texels whose colours do not sum to a whole number.
struct TestPicture {
  std::vector<Float4> texels;
  std::vector<float> rows{0.5f, 1.0f};
  LightTexture texture{0, 0, 4, 2};

  TestPicture() {
    for (int i = 0; i < 8; ++i) {
      const auto x = static_cast<float>(i);
      texels.push_back({0.1f * x, 0.9f - 0.1f * x, static_cast<float>(i % 3) / 3, 0});
    }
  }
  LightsView view() const {
    return {.textures = &texture, .texels = texels.data(), .rows = rows.data()};
  }
};

TEST(LightTexture, InterpolatesLinearlyBetweenTexels) {
  const TestPicture picture;
  const LightsView view = picture.view();
  const auto green = [&](float across, float down) {
    return colour_at<TextureEdge::kClamp>(view, picture.texture, {across, down}).y;
  };
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(green((static_cast<float>(i) + 0.5f) / 4, (static_cast<float>(j) + 0.5f) / 2),
                  picture.texels[static_cast<std::size_t>(i + 4 * j)].y, 1e-6f);
    }
  }
  EXPECT_NEAR(green(0.25f, 0.25f), 0.85f, 1e-6f) << "between the first two";
  EXPECT_NEAR(green(0.125f, 0.5f), 0.7f, 1e-6f) << "between the rows";
  EXPECT_NEAR(green(0, 0), 0.9f, 1e-6f) << "the edge continues";
  EXPECT_NEAR(colour_at<TextureEdge::kWrapAcross>(view, picture.texture, {0, 0}).y, 0.75f, 1e-6f)
      << "half of the last";
}

/// A light with a texture is the sum of many small untextured ones that have its colour in their
/// middle.
TEST(TexturedLights, EqualTheSumOfTheirParts) {
  const TestPicture picture;
  const LightsView view = picture.view();
  constexpr int kParts = 40;
  const Float3 place{3, -4, 5};
  AreaLight whole = rectangle({-10, -20, 50}, {0, 30, 0}, {20, 5, -3});
  double parts = 0;
  for (int j = 0; j < kParts; ++j) {
    for (int i = 0; i < kParts; ++i) {
      const auto x = static_cast<float>(i), y = static_cast<float>(j);
      AreaLight part = rectangle(whole.corner + whole.u * (x / kParts) + whole.v * (y / kParts),
                                 whole.u * (1.0f / kParts), whole.v * (1.0f / kParts));
      const Float3 colour = colour_at<TextureEdge::kClamp>(
          view, picture.texture, {(x + 0.5f) / kParts, (y + 0.5f) / kParts});
      const LightSample s = sampled<kPlain>(part, place, 0.5f, 0.5f);
      parts += static_cast<double>(s.irradiance.y) * static_cast<double>(colour.y);
    }
  }
  whole.texture = 0;
  test::Moments points, rays;
  Random random(1, 2, 3);
  for (int i = 0; i < kSamples; ++i) {
    const Random::Pair u = random.two();
    points.add(
        static_cast<double>(sample_light<kTextured>(view, whole, place, u.a, u.b).irradiance.y));
    const Random::Pair w = random.two();
    const LightHit hit = meet_light<kTextured>(view, whole, place, sample_sphere(w.a, w.b));
    rays.add(hit.met ? static_cast<double>(hit.radiance.y) * 4 * std::numbers::pi : 0);
  }
  const double limit = test::critical_z(test::sidak(kAlpha, 2));
  EXPECT_NEAR(points.mean, parts, limit * points.error_of_mean() + 5e-4 * parts);
  EXPECT_NEAR(rays.mean, parts, limit * rays.error_of_mean());
}

TEST(TexturedLights, SamplesAndRaysSeeTheSameColour) {
  const TestPicture picture;
  const LightsView view = picture.view();
  for (Case c : cases()) {
    c.light.texture = 0;
    Random random(3, 2, 1);
    for (int i = 0; i < 2000; ++i) {
      const Random::Pair u = random.two();
      const LightSample s = sample_light<kTextured>(view, c.light, c.place, u.a, u.b);
      if (!s.lit) continue;
      const LightHit hit = meet_light<kTextured>(view, c.light, c.place, s.direction);
      if (!hit.met) continue;
      const float slack = c.light.shape == LightShape::kSphere ? 0.2f : 5e-3f;
      ASSERT_NEAR(s.irradiance.y * s.density, hit.radiance.y, slack);
    }
  }
}

TEST(PickLight, FollowsTheProbabilitiesAndReturnsAUniformRemainder) {
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
  const LightsView view{.area = lights.data(), .count = static_cast<std::uint32_t>(lights.size())};
  std::array<std::uint64_t, 7> picked{};
  Counts stretched_counts;
  Random random(1, 2, 3);
  for (int i = 0; i < kSamples; ++i) {
    float u = random.one();
    ++picked[pick_light(view, u)];
    ASSERT_GE(u, 0.0f);
    ASSERT_LT(u, 1.0f);
    stretched_counts.add(static_cast<double>(u));
  }
  const double limit = test::critical_z(test::sidak(kAlpha, 8));
  for (std::size_t i = 0; i < picked.size(); ++i) {
    const double p = powers[i] / total;
    EXPECT_NEAR(static_cast<double>(picked[i]), kSamples * p,
                limit * std::sqrt(kSamples * p) + 1 + kSamples * 1e-7)
        << i;
  }
  EXPECT_TRUE(stretched_counts.uniform(test::sidak(kAlpha, 8)));
}

}  // namespace
}  // namespace diaphane::render
