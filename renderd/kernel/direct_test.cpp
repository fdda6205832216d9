// Direct light in empty space, where every ray arrives. The strategies add up to one integral for
// any choice of their weights and any additional features.
#include "renderd/kernel/direct.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "renderd/kernel/medium.h"
#include "tests/support/renderd/test_lights.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr double kAlpha = 1e-4;
const std::uint64_t kSamples = test::gate_or_nightly(50'000, 400'000);

/// Lights of several kinds: a rectangle, a disk, a sphere with a texture, an environment with a
/// bright spot.
struct Lights {
  std::vector<AreaLight> area;
  std::vector<Float4> texels;
  std::vector<float> rows;
  LightTexture texture{0, 0, 8, 4};
  EnvironmentMap map{};

  Lights() {
    area.push_back(test::rectangle({-10, -20, 30}, {0, 30, 0}, {20, 5, -3}));
    area.push_back(test::disk({25, 0, -20}, {-1, 0, 0}, 12, {6, 4, 1}));
    area.push_back(test::sphere({-12, 14, -9}, 8, {1, 2, 4}));
    area.back().texture = 0;
    const float shares[] = {0.5f, 0.2f, 0.3f};
    float sum = 0;
    for (std::size_t i = 0; i < area.size(); ++i) {
      area[i].probability = shares[i];
      sum += shares[i];
      area[i].cumulative = sum;
    }
    area.back().cumulative = 1;
    for (int j = 0; j < 4; ++j) {
      // Half of the row's probability is in the spot and the rest is even. It is deliberately not
      // in proportion to the light.
      float w = 0;
      for (int i = 0; i < 8; ++i) {
        w += i == 5 ? 0.5f : 0.5f / 7;
        const float bright = i == 5 && j == 1 ? 9.0f : 0.3f;
        texels.push_back({bright, 0.5f * bright, 0.2f, i == 7 ? 1.0f : w});
      }
      rows.push_back(0.25f * static_cast<float>(j + 1));
    }
    map = {.right = {0, 1, 0},
           .middle = {0, 0, 1},
           .up = {1, 0, 0},
           .radiance = {1, 1, 2},
           .probability = 1,
           .cumulative = 1,
           .texture = 0};
  }
  LightsView view() const {
    return {.area = area.data(),
            .count = static_cast<std::uint32_t>(area.size()),
            .environment = {0.5f, 0.25f, 0.125f},
            .map_count = 1,
            .maps = &map,
            .textures = &texture,
            .texels = texels.data(),
            .rows = rows.data()};
  }
};

constexpr Features kAllLights = Features{}
                                    .with(Feature::kAreaLights)
                                    .with(Feature::kManyLights)
                                    .with(Feature::kShapedLights)
                                    .with(Feature::kTexturedLights)
                                    .with(Feature::kEnvironment)
                                    .with(Feature::kTexturedEnvironment);
constexpr Features kForwards = kAllLights.with(Feature::kAnisotropicPhase);
constexpr Features kShiny = kForwards.with(Feature::kSurfaces).with(Feature::kGloss);

/// Estimates the green light at the origin with one sample of each strategy.
template <Features F>
test::Moments direct_light(const LightsView& lights, Mis mis, const Scatter<F>& scatter,
                           std::uint64_t seed) {
  SceneView<LinearVolume> scene{};
  scene.spacing = scene.inverse_spacing = {1, 1, 1};
  scene.lights = lights;
  scene.mis = mis;
  test::Moments moments;
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    Random random(seed, 0, i);
    double sum = 0;
    for (std::uint32_t s = 0; s < strategy_count<F>(); ++s) {
      const Random::Pair u = random.two();
      if (!is_of_use<F>(scene, strategy_at<F>(s))) continue;
      const LightRay ray = light_ray<F>(scene, {0, 0, 0}, scatter, strategy_at<F>(s), u);
      if (ray.lit) sum += static_cast<double>(ray.weight.y);
    }
    moments.add(sum);
  }
  return moments;
}

template <Features F>
Scatter<F> phase_scatter(float g) {
  Scatter<F> s{};
  s.albedo = {0.9f, 0.8f, 0.7f};
  s.incoming = normalize(Float3{0.3f, -0.2f, 1});
  s.g = g;
  return s;
}

Scatter<kShiny> surface_scatter(float roughness) {
  Scatter<kShiny> s = phase_scatter<kShiny>(0);
  s.surface = true;
  s.normal = normalize(Float3{0.2f, 0.6f, -1});
  s.specular = {0.3f, 0.4f, 0.5f};
  s.roughness = roughness;
  return s;
}

template <Features F>
void expect_same_for_every_choice(const Scatter<F>& scatter, const std::string& what) {
  const Lights lights;
  const test::Moments both = direct_light<F>(lights.view(), Mis::kBoth, scatter, 1);
  const test::Moments light = direct_light<F>(lights.view(), Mis::kLight, scatter, 2);
  const test::Moments matter = direct_light<F>(lights.view(), Mis::kScatter, scatter, 3);
  const double critical = test::critical_z(test::sidak(kAlpha, 2));
  EXPECT_GT(both.mean, 0);
  EXPECT_LT(std::abs(test::welch(both, light)), critical)
      << what << " light " << light.mean << " both " << both.mean;
  EXPECT_LT(std::abs(test::welch(both, matter)), critical)
      << what << " scatter " << matter.mean << " both " << both.mean;
}

TEST(DirectLight, EverySamplingStrategyHasTheSameMean) {
  expect_same_for_every_choice(phase_scatter<kForwards>(0.9f), "g = 0.9");
  expect_same_for_every_choice(phase_scatter<kForwards>(-0.6f), "g = -0.6");
  expect_same_for_every_choice(phase_scatter<kForwards>(0), "g = 0");
  expect_same_for_every_choice(surface_scatter(0.3f), "gloss");
  expect_same_for_every_choice(surface_scatter(0.9f), "dull");
}

TEST(DirectLight, ExtraFeaturesKeepTheMean) {
  const Lights lights;
  const double critical = test::critical_z(test::sidak(kAlpha, 3));
  const test::Moments lean =
      direct_light<kAllLights>(lights.view(), Mis::kBoth, phase_scatter<kAllLights>(0), 4);
  const test::Moments more =
      direct_light<kForwards>(lights.view(), Mis::kBoth, phase_scatter<kForwards>(0), 5);
  EXPECT_LT(std::abs(test::welch(lean, more)), critical);
  // One rectangle and an untextured sky.
  LightsView few = lights.view();
  few.count = 1;
  few.map_count = 0;
  std::vector<AreaLight> one{lights.area[0]};
  one[0].probability = one[0].cumulative = 1;
  few.area = one.data();
  constexpr Features kFew = Features{}.with(Feature::kAreaLights).with(Feature::kEnvironment);
  const test::Moments plain = direct_light<kFew>(few, Mis::kBoth, phase_scatter<kFew>(0), 6);
  EXPECT_LT(std::abs(test::welch(
                plain, direct_light<kAllLights>(few, Mis::kBoth, phase_scatter<kAllLights>(0), 7))),
            critical);
  EXPECT_LT(std::abs(test::welch(
                plain, direct_light<kShiny>(few, Mis::kBoth, phase_scatter<kShiny>(0), 8))),
            critical);
}

/// Narrow scattering finds lights for which points on them work badly. The combination is nearly as
/// good as the better technique.
TEST(DirectLight, CombinationIsNearlyAsGoodAsTheBetterTechnique) {
  const Lights lights;
  LightsView one = lights.view();
  one.environment = {};
  for (const float roughness : {0.05f, 0.3f, 1.0f}) {
    const auto variance = [&](Mis mis) {
      return direct_light<kShiny>(one, mis, surface_scatter(roughness), 9).variance();
    };
    const double better = std::min(variance(Mis::kLight), variance(Mis::kScatter));
    EXPECT_LT(variance(Mis::kBoth), 1.5 * better) << roughness;
  }
}

TEST(DirectLight, OmitsStrategiesThatNoFeatureNeeds) {
  EXPECT_EQ(strategy_count<Features{}>(), 0u);
  EXPECT_EQ(strategy_count<Features{}.with(Feature::kAreaLights)>(), 1u);
  EXPECT_EQ(strategy_count<Features{}.with(Feature::kAreaLights).with(Feature::kEnvironment)>(),
            2u);
  EXPECT_EQ(strategy_count<kAllLights>(), 3u);
  EXPECT_EQ(strategy_count<kForwards>(), 4u);
}

/// The weights of both techniques add up to one for any densities.
TEST(Share, WeightsOfBothTechniquesAddUpToOne) {
  for (const float a : {1e-30f, 1e-3f, 1.0f, 1e12f, 3e38f}) {
    for (const float b : {0.0f, 1e-30f, 1e-3f, 1.0f, 1e12f, 3e38f}) {
      const float mine = share(Mis::kBoth, Mis::kLight, a, b);
      const float other = b > 0 ? share(Mis::kBoth, Mis::kScatter, b, a) : 0.0f;
      EXPECT_NEAR(mine + other, 1.0f, 1e-6f) << a << ' ' << b;
    }
  }
  EXPECT_EQ(share(Mis::kLight, Mis::kLight, 1, 5), 1.0f);
  EXPECT_EQ(share(Mis::kLight, Mis::kScatter, 1, 5), 0.0f);
}

}  // namespace
}  // namespace diaphane::render
