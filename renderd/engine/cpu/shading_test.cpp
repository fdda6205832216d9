// Tests how scatter_at chooses between surface and phase function, by the gradient in world
// lengths.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "renderd/kernel/scatter.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr double kAlpha = 1e-3;
constexpr Features kHybridOnly = Features{}.with(Feature::kSurfaces).with(Feature::kHybrid);
constexpr Features kSurfacesOnly = Features{}.with(Feature::kSurfaces);
constexpr Features kGlossy = kSurfacesOnly.with(Feature::kGloss);

/// Values rise by `slope` per mm along `direction`, in voxels of 1 x 0.5 x 3 mm.
volume::Volume ramp(Double3 direction, double slope) {
  return test::make_volume({24, 40, 10}, {1, 0.5, 3}, [=](double x, double y, double z) {
    return 10000 + slope * dot(direction, Double3{x - 12, 0.5 * (y - 20), 3 * (z - 5)});
  });
}

diaphane::v1::Scene scene_of(diaphane::v1::Shading::Mode mode) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.clear_transfer_function();
  test::add_channel(*scene.mutable_transfer_function(), {{0, 0}, {20000, 1}}, 0.5, 0.5, 0.5);
  scene.mutable_transfer_function()->set_extinction_per_mm(7);
  scene.mutable_shading()->set_mode(mode);
  scene.mutable_shading()->set_gradient_scale(0.04);
  return scene;
}

TEST(Gradient, IsInWorldSpaceForAnySpacing) {
  const Double3 direction = normalize(Double3{1, -2, 0.5});
  const test::Prepared p(ramp(direction, 400), scene_of(diaphane::v1::Shading::SURFACE));
  const auto view = p.view();
  for (const Float3 incoming : {Float3{1, 0, 0}, Float3{0, 1, 0}, Float3{0, 0, -1}}) {
    const auto s = scatter_at<kSurfacesOnly>(view, {12.3f, 20.1f, 5.2f}, 10000, incoming, 0.5f);
    ASSERT_TRUE(s.surface);
    EXPECT_LT(dot(s.normal, incoming), 0) << "the normal faces the viewer";
    EXPECT_NEAR(std::abs(dot(to_double(s.normal), direction)), 1, 1e-5);
  }
  // The opacity rises by 400 / 20000 per mm.
  EXPECT_NEAR(gradient_at(view, {12.3f, 20.1f, 5.2f}, 10000).slope, 7 * 0.02, 7e-4);
}

/// A place is a surface with probability 1 - exp(-|gradient of the opacity| / scale).
TEST(Hybrid, ChoosesSurfaceOrVolumeByTheGradient) {
  constexpr std::array kSlopes{0.0, 100.0, 400.0, 1500.0};
  constexpr int kTries = 100'000;
  const double limit = test::critical_z(test::sidak(kAlpha, kSlopes.size()));
  for (const double slope : kSlopes) {
    const test::Prepared p(ramp({1, 0, 0}, slope), scene_of(diaphane::v1::Shading::HYBRID));
    const auto view = p.view();
    Random random(1, 2, 3);
    int surfaces = 0;
    for (int i = 0; i < kTries; ++i) {
      surfaces += scatter_at<kHybridOnly>(view, {12, 20, 5}, view.volume.at({12, 20, 5}), {0, 1, 0},
                                          random.one())
                      .surface;
    }
    const double share = -std::expm1(-slope / 20000 / 0.04);
    EXPECT_NEAR(surfaces, kTries * share,
                limit * std::sqrt(kTries * share * (1 - share)) + 2e-3 * kTries * share)
        << slope;
  }
}

TEST(Surfaces, FallBackToThePhaseFunctionWithoutGradient) {
  diaphane::v1::Scene scene = scene_of(diaphane::v1::Shading::SURFACE);
  const test::Prepared flat(ramp({1, 0, 0}, 0), scene);
  EXPECT_FALSE(scatter_at<kSurfacesOnly>(flat.view(), {12, 20, 5}, 10000, {0, 1, 0}, 0.5f).surface);
  // The values vary, but the transfer function does not.
  scene.mutable_transfer_function()->mutable_channels(0)->mutable_opacity(0)->set_opacity(1);
  const test::Prepared full(ramp({1, 0, 0}, 400), scene);
  EXPECT_FALSE(scatter_at<kSurfacesOnly>(full.view(), {12, 20, 5}, 10000, {0, 1, 0}, 0.5f).surface);
}

/// At the border of a channel that is full from its first value, a surface is found within a voxel,
/// and its normal is that of the values and not of the axes.
TEST(Surfaces, AreFoundAtAStepOfTheTransferFunction) {
  diaphane::v1::Scene scene = scene_of(diaphane::v1::Shading::SURFACE);
  scene.mutable_transfer_function()->mutable_channels(0)->mutable_opacity(0)->set_value(9990);
  scene.mutable_transfer_function()->mutable_channels(0)->mutable_opacity(0)->set_opacity(1);
  const Double3 direction = normalize(Double3{1, 2, 0});
  const test::Prepared p(ramp(direction, 400), scene);
  const auto s = scatter_at<kSurfacesOnly>(p.view(), {12, 20, 5}, 10000, Float3{0, 1, 0}, 0.5f);
  ASSERT_TRUE(s.surface);
  EXPECT_NEAR(std::abs(dot(to_double(s.normal), direction)), 1, 1e-4);
}

TEST(Surfaces, AverageTheGlossOfTheirChannels) {
  diaphane::v1::Scene scene = scene_of(diaphane::v1::Shading::SURFACE);
  auto& f = *scene.mutable_transfer_function();
  test::set(f.mutable_channels(0)->mutable_specular(), 0.2, 0.4, 0);
  f.mutable_channels(0)->set_gloss(1);
  auto* second = test::add_channel(f, {{0, 0.25}, {20000, 0.25}});
  test::set(second->mutable_specular(), 0.8, 0.4, 0);
  test::set(second->mutable_emission(), 3, 0, 9);
  const test::Prepared p(ramp({1, 0, 0}, 400), scene);
  EXPECT_EQ(p.scene().features.has(Feature::kGloss), true);
  EXPECT_EQ(p.scene().features.has(Feature::kEmission), true);
  const auto s = scatter_at<kGlossy>(p.view(), {12, 20, 5}, 10000, {0, 1, 0}, 0.5f);
  // At 10000 the opacities are 0.5 and 0.25.
  EXPECT_NEAR(s.specular.x, (0.5 * 0.2 + 0.25 * 0.8) / 0.75, 1e-5);
  EXPECT_NEAR(s.specular.y, 0.4, 1e-5);
  EXPECT_NEAR(s.roughness, 1.0 / 9, 1e-5) << "gloss 2/3";
  EXPECT_NEAR(emission_at(p.view().transfer, 10000).z, 3, 1e-5);
}

/// These tables exist only while the scene needs them.
TEST(Tables, GlossAndEmissionTablesExistOnlyIfNeeded) {
  diaphane::v1::Scene scene = scene_of(diaphane::v1::Shading::SURFACE);
  auto* channel = scene.mutable_transfer_function()->mutable_channels(0);
  const auto tables = [&] {
    const test::Prepared p(ramp({1, 0, 0}, 400), scene);
    return std::pair{p.scene().transfer->gloss.size(), p.scene().transfer->emission.size()};
  };
  EXPECT_EQ(tables(), std::pair(std::size_t{0}, std::size_t{0}));
  test::set(channel->mutable_specular(), 0.2, 0.2, 0.2);
  EXPECT_GT(tables().first, 0u);
  EXPECT_EQ(tables().second, 0u);
  test::set(channel->mutable_emission(), 0, 1, 0);
  EXPECT_GT(tables().second, 0u);
  channel->set_disabled(true);
  EXPECT_EQ(tables(), std::pair(std::size_t{0}, std::size_t{0}));
}

}  // namespace
}  // namespace diaphane::render
