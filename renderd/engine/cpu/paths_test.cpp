// Tests paths of many collisions by laws that hold for every scene: in a furnace, everything is as
// bright as its walls. The tests use the kernels that the engine calls. Each scene is rendered with
// its own kernel and with the one that has all features.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "renderd/engine/cpu/kernel.h"
#include "renderd/kernel/variants.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr double kAlpha = 1e-3;
constexpr Canvas kCanvas{16, 16};
const std::uint32_t kPictures = test::gate_or_nightly(40u, 200u);
/// Returns the limit for one of `tests` comparisons of means over kPictures observations.
double limit_of(std::size_t tests) {
  return test::critical_t(test::sidak(kAlpha, tests), kPictures - 1);
}

/// Returns the mean of a picture's red component. Each sample of the whole picture is one
/// observation.
test::Moments red_of(const SceneView<LinearVolume>& view, Features features,
                     std::uint32_t samples) {
  const CpuKernel kernel = cpu_kernel(features);
  std::vector<Sample> pixels(std::size_t{view.width} * view.height);
  test::Moments m;
  for (std::uint32_t i = 0; i < samples; ++i) {
    kernel(view, CpuTile{0, 0, view.width, view.height, i, pixels.data()});
    double sum = 0;
    for (const Sample& s : pixels) sum += s.radiance.x;
    m.add(sum / static_cast<double>(pixels.size()));
  }
  return m;
}

struct Look {
  const char* name;
  double g;
  diaphane::v1::Shading::Mode mode;
};
constexpr Look kLooks[] = {{"isotropic", 0, diaphane::v1::Shading::PHASE},
                           {"forward", 0.8, diaphane::v1::Shading::PHASE},
                           {"backward", -0.5, diaphane::v1::Shading::PHASE},
                           {"surfaces", 0, diaphane::v1::Shading::SURFACE},
                           {"hybrid", 0.4, diaphane::v1::Shading::HYBRID}};

/// A head of spikes and overlaps before a sky of radiance 1.
diaphane::v1::Scene furnace(const Look& look, double extinction, std::uint32_t bounces) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.clear_lights();
  test::add_sky(scene, 1);
  scene.clear_transfer_function();
  auto& f = *scene.mutable_transfer_function();
  test::add_channel(f, {{100, 0}, {15000, 0.7}, {30000, 0.2}}, 1, 0.5, 0);
  test::add_channel(f, {{20000, 0}, {20100, 1}, {20200, 0}}, 1, 0.5, 0);
  f.set_extinction_per_mm(extinction);
  scene.mutable_phase()->set_g(look.g);
  scene.mutable_shading()->set_mode(look.mode);
  scene.set_bounces(bounces);
  return scene;
}

/// With albedo 1 nothing is absorbed, so only paths that were cut off lose light. Every ray leaves
/// the volume with a probability of at least exp(-depth of the diagonal), so after n collisions at
/// most (1 - that)^n of all paths remain.
TEST(WhiteFurnace, ApproachesOneWithMoreBounces) {
  constexpr double kExtinction = 0.05;
  const double diagonal = std::sqrt(48.0 * 48 + 48 * 48 + 48 * 48);
  const double stays = -std::expm1(-kExtinction * diagonal);
  const double limit = limit_of(3 * 2 * std::size(kLooks));
  for (const Look& look : kLooks) {
    for (const bool roulette : {true, false}) {
      double before = 0;
      for (std::uint32_t bounces : {1u, 8u, 1024u}) {
        const test::Prepared p(test::skull_volume(), furnace(look, kExtinction, bounces), kCanvas);
        SceneView<LinearVolume> view = p.view(bounces + (roulette ? 0 : 1));
        view.roulette = roulette;
        const test::Moments m = red_of(view, p.scene().features, kPictures);
        const double noise = limit * m.error_of_mean() + 1e-5;
        EXPECT_LT(m.mean, 1 + noise) << look.name << " " << bounces;
        EXPECT_GT(m.mean, before - noise) << look.name << " " << bounces;
        EXPECT_GT(m.mean, 1 - std::pow(stays, bounces) - noise) << look.name << " " << bounces;
        before = m.mean;
      }
    }
  }
}

/// The classical test: matter that emits as much as it absorbs, inside walls of the same
/// brightness, is as bright as the walls, whatever its properties. The requirement is 1 +- 0.025,
/// and the statistical bound is much tighter.
TEST(EmittingSphere, EnclosedEmitterIsAsBrightAsItsWalls) {
  const double limit = limit_of(2 * 2 * std::size(kLooks));
  for (const Look& look : kLooks) {
    for (const double extinction : {0.1, 4.0}) {
      diaphane::v1::Scene scene = furnace(look, extinction, 64);
      auto& channels = *scene.mutable_transfer_function()->mutable_channels();
      test::set(channels[0].mutable_diffuse(), 0.75, 0, 0);
      test::set(channels[0].mutable_emission(), 0.25, 0, 0);
      test::set(channels[1].mutable_diffuse(), 0.25, 0, 0);
      test::set(channels[1].mutable_emission(), 0.75, 0, 0);
      const test::Prepared p(test::skull_volume(), scene, kCanvas);
      for (const bool roulette : {true, false}) {
        SceneView<LinearVolume> view = p.view(roulette ? 3 : 4);
        view.roulette = roulette;
        const test::Moments m = red_of(view, p.scene().features, kPictures);
        // At most 0.75^64 of a path's weight remains at the end.
        EXPECT_NEAR(m.mean, 1, limit * m.error_of_mean() + 1e-5) << look.name << " " << extinction;
        EXPECT_NEAR(m.mean, 1, 0.025) << look.name << " " << extinction;
      }
    }
  }
}

/// The reverse of Beer and Lambert: the brightness of a homogeneous cube that only emits is 1 -
/// exp(-depth).
TEST(Emission, HomogeneousCubeEmitsItsAbsorptance) {
  const double limit = test::critical_z(test::sidak(kAlpha, 4));
  for (const double depth : {0.01, 0.5, 3.0, 1e4}) {
    diaphane::v1::Scene scene;
    auto& f = *scene.mutable_transfer_function();
    auto* channel = test::add_channel(f, {{0, 0.5}, {2000, 0.5}}, 0, 0, 0);
    test::set(channel->mutable_emission(), 3, 0, 0);
    f.set_extinction_per_mm(2 * depth / 20);
    test::set_camera(scene, 0, -500, 0, 0.002);
    const test::Prepared p(test::constant_volume(10, 1000, 2), scene, {4, 4});
    const test::Moments m =
        red_of(p.view(), p.scene().features, test::gate_or_nightly(10'000u, 40'000u));
    const double exact = -3 * std::expm1(-depth);
    EXPECT_NEAR(m.mean, exact, limit * m.error_of_mean() + 1e-5 * exact) << depth;
  }
}

/// The shading has no effect if light is scattered once and paths are cut off there.
TEST(Bounces, OneBounceEqualsNone) {
  diaphane::v1::Scene scene = test::skull_scene();
  const test::Prepared none(test::skull_volume(), scene, kCanvas);
  scene.set_bounces(1);
  const test::Prepared one(test::skull_volume(), scene, kCanvas);
  EXPECT_EQ(one.scene().features, none.scene().features);
  EXPECT_EQ(red_of(one.view(), one.scene().features, 4).mean,
            red_of(none.view(), none.scene().features, 4).mean);
}

/// With a lamp and a sky, paths with and without roulette have the same mean, and so does the
/// kernel with all features.
TEST(Paths, RouletteAndExtraFeaturesKeepTheMean) {
  const double limit = limit_of(3 * std::size(kLooks));
  for (const Look& look : kLooks) {
    diaphane::v1::Scene scene = test::skull_scene();
    scene.mutable_phase()->set_g(look.g);
    scene.mutable_shading()->set_mode(look.mode);
    scene.set_bounces(12);
    const test::Prepared p(test::skull_volume(), scene, {24, 24});
    SceneView<LinearVolume> plain = p.view(1), all = p.view(2), without = p.view(3);
    without.roulette = false;
    const test::Moments a = red_of(plain, p.scene().features, kPictures);
    const test::Moments b = red_of(all, kAllFeatures, kPictures);
    const test::Moments c = red_of(without, p.scene().features, kPictures);
    EXPECT_LT(std::abs(test::welch(a, b)), limit) << look.name;
    EXPECT_LT(std::abs(test::welch(a, c)), limit) << look.name;
    EXPECT_LT(std::abs(test::welch(b, c)), limit) << look.name;
  }
}

/// Inside matter that scatters forwards, a wide lamp is found by sampling points on it, by paths
/// that hit it, or by both with weights.
TEST(Paths, EveryLightSamplingTechniqueHasTheSameMean) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.clear_lights();
  test::add_lamp(scene, -20, 15, 40, 120, 3);
  scene.mutable_display()->set_show_environment(false);
  scene.mutable_transfer_function()->set_extinction_per_mm(0.3);
  scene.mutable_phase()->set_g(0.7);
  scene.set_bounces(12);
  const test::Prepared p(test::skull_volume(), scene, {24, 24});
  test::Moments of[3];
  for (const Mis mis : {Mis::kBoth, Mis::kLight, Mis::kScatter}) {
    SceneView<LinearVolume> view = p.view(1 + static_cast<std::uint64_t>(mis));
    view.mis = mis;
    of[static_cast<std::size_t>(mis)] = red_of(view, p.scene().features, kPictures);
  }
  const double limit = limit_of(2);
  EXPECT_LT(std::abs(test::welch(of[0], of[1])), limit);
  EXPECT_LT(std::abs(test::welch(of[0], of[2])), limit);
}

/// Tests the same for one collision, with surfaces and gloss.
TEST(Shading, ExtraFeaturesKeepTheMean) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.mutable_shading()->set_mode(diaphane::v1::Shading::SURFACE);
  test::set(scene.mutable_transfer_function()->mutable_channels(0)->mutable_specular(), 0.1, 0.1,
            0.1);
  scene.mutable_transfer_function()->mutable_channels(0)->set_gloss(0.5);
  const test::Prepared p(test::skull_volume(), scene, {24, 24});
  EXPECT_LT(std::abs(test::welch(red_of(p.view(1), p.scene().features, kPictures),
                                 red_of(p.view(2), kAllFeatures, kPictures))),
            limit_of(1));
}

/// Extreme parameters give no value that is not finite, and none that is brighter than the
/// brightest light.
TEST(Paths, StayFiniteInExtremeMedia) {
  for (const double extinction : {1e-6, 1e3, 1e6}) {
    for (const double g : {-0.999999, 0.0, 0.99999999}) {
      diaphane::v1::Scene scene = furnace(kLooks[4], extinction, extinction > 1e5 ? 3 : 256);
      scene.mutable_phase()->set_g(g);
      auto* channel = scene.mutable_transfer_function()->mutable_channels(0);
      test::set(channel->mutable_specular(), 1, 0.5, 0);
      channel->set_gloss(1);
      const test::Prepared p(test::skull_volume(), scene, {6, 6});
      const CpuKernel kernel = cpu_kernel(p.scene().features);
      std::vector<Sample> pixels(36);
      for (std::uint32_t i = 0; i < 8; ++i) {
        kernel(p.view(), CpuTile{0, 0, 6, 6, i, pixels.data()});
        for (const Sample& s : pixels) ASSERT_TRUE(is_finite(s.radiance)) << extinction << " " << g;
      }
    }
  }
}

}  // namespace
}  // namespace diaphane::render
