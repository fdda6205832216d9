// Labels of voxels. full_scene_test.cpp and brute_force_test.cpp compare their pictures with
// independent estimators.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>
#include <vector>

#include "renderd/engine/cpu/engine.h"
#include "renderd/kernel/estimator.h"
#include "renderd/kernel/variants.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render {
namespace {

/// Matter that grows denser along x, with three labels whose borders lie anywhere.
volume::Volume marked_volume() {
  volume::Volume volume = test::make_volume(
      {37, 21, 26}, {1, 1.25, 0.75},
      [](double x, double y, double z) { return 500 + 20 * x + 9 * std::sin(y) * z; });
  test::mark(volume, [](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return y < 8 ? 1 : x > 15 && z < 16 ? 2 : (x + z) % 11 == 0 ? 3 : 0;
  });
  return volume;
}

diaphane::v1::Scene scene_with(std::initializer_list<double> opacities, double extinction = 1) {
  diaphane::v1::Scene scene;
  test::add_channel(*scene.mutable_transfer_function(), {{0, 0.05}, {1500, 1}});
  scene.mutable_transfer_function()->set_extinction_per_mm(extinction);
  test::add_sky(scene, 1);
  test::set_camera(scene, 30, 70, 20, 40);
  std::uint32_t number = 0;
  for (const double opacity : opacities) {
    auto* look = scene.add_labels();
    look->set_number(number += 10);
    look->set_opacity(opacity);
  }
  return scene;
}

TEST(Labels, BoundsHoldEverywhere) {
  const test::Prepared p(marked_volume(), scene_with({0.25, 0, 0.75}));
  const auto view = p.view();
  ASSERT_TRUE(p.scene().features.has(Feature::kLabels));
  const auto medium = medium_of<kOneScan>(view, {});
  std::mt19937 generator(7);
  const Int3 n = view.volume.size;
  const auto place = [&](std::int32_t size) {
    return std::uniform_real_distribution<float>(0, static_cast<float>(size))(generator);
  };
  std::size_t hidden = 0;
  for (int i = 0; i < 200000; ++i) {
    const Float3 at{place(n.x), place(n.y), place(n.z)};
    const float extinction = medium.extinction(view.volume.at(at), at);
    const auto cell = [&](float v, float edge) { return static_cast<std::int32_t>(v / edge); };
    const std::size_t index = static_cast<std::size_t>(
        cell(at.x, 8) + view.grid.size.x * (cell(at.y, 8) + view.grid.size.y * cell(at.z, 8)));
    ASSERT_LE(view.grid.cells[index].minorant, extinction);
    ASSERT_GE(view.grid.cells[index].majorant, extinction);
    const Int3 voxels{cell(at.x + 0.5f, 1), cell(at.y + 0.5f, 1), cell(at.z + 0.5f, 1)};
    ASSERT_GE(medium.majorant(voxels, static_cast<std::int32_t>(index)), extinction);
    hidden += extinction == 0 ? 1 : 0;
  }
  EXPECT_GT(hidden, 20000u) << "label 2 is hidden";
}

TEST(Labels, HiddenMatterIsSkipped) {
  diaphane::v1::Scene scene = scene_with({1, 1, 1});
  scene.mutable_labels(1)->set_solo(true);
  const test::Prepared p(marked_volume(), scene);
  const auto& bounds = bounds_of(p.scene());
  const auto empty = [](const CellBounds& b) { return b.majorant == 0; };
  // Label 2 is at x > 15, y > 7 and z < 16, so only cells from the second row on are occupied.
  EXPECT_GT(std::count_if(bounds.begin(), bounds.end(), empty), 20);
  EXPECT_EQ(p.view().grid.occupied.low.x, 8);
  EXPECT_EQ(p.view().grid.occupied.low.y, 0) << "the cells of a voxel beside the label, too";
  EXPECT_EQ(p.view().grid.occupied.high.z, 24);
}

TEST(Labels, CostNothingIfTheyChangeNothing) {
  for (const auto& scene : {scene_with({}), scene_with({1, 1, 1})}) {
    const test::Prepared p(marked_volume(), scene);
    EXPECT_FALSE(p.scene().features.has(Feature::kLabels));
    EXPECT_FALSE(kVariants[variant_for(p.scene().features)].has(Feature::kLabels));
    EXPECT_TRUE(use_exact_walk(p.scene(), Method{}));
  }
  volume::Volume plain = marked_volume();
  plain.label_set = {};
  const test::Prepared p(plain, scene_with({0, 0.5}));
  EXPECT_FALSE(p.scene().features.has(Feature::kLabels)) << "looks of labels that the scan lacks";
}

TEST(Labels, KernelsOfScenesWithoutLabelsHaveNoCodeForThem) {
  // A scene of one scan with every other feature must not need the general kernels.
  const Features all = kOneScan.without(Feature::kLabels);
  EXPECT_FALSE(kVariants[variant_for(all)].has(Feature::kLabels));
  EXPECT_FALSE(kVariants[variant_for(all.without(Feature::kGuides))].has(Feature::kLabels));
}

TEST(Labels, GeneralKernelRendersScenesWithoutLabelsAlike) {
  volume::Volume plain = marked_volume();
  plain.label_set = {};
  const test::Prepared p(plain, scene_with({}), {16, 16});
  const auto view = p.view();
  constexpr Features kLean = kAllFeatures.without(Feature::kLabels);
  for (std::uint32_t i = 0; i < 256; ++i) {
    const Sample with = estimate<kAllFeatures>(view, i % 16, i / 16, 0);
    const Sample without = estimate<kLean>(view, i % 16, i / 16, 0);
    EXPECT_EQ(with.radiance.x, without.radiance.x);
  }
}

Result<std::vector<float>> picture_of(const diaphane::v1::Scene& scene, Method method) {
  const auto engine = make_cpu_engine(2);
  const auto loaded = engine->load(marked_volume()).value();
  const auto renderer = engine->renderer(loaded, 3, 0, method).value();
  if (auto set = renderer->set_scene(scene, {24, 24}); !set) return tl::unexpected(set.error());
  EXPECT_TRUE(renderer->render(4, nullptr));
  PictureRgbF out;
  EXPECT_TRUE(renderer->radiance(out));
  return out.pixels;
}

TEST(Labels, AreTrackedBecauseTheExactWalkRefusesThem) {
  const diaphane::v1::Scene scene = scene_with({0.5, 0.25});
  EXPECT_EQ(picture_of(scene, {.walk = Walk::kExact}).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(picture_of(scene, {.walk = Walk::kAuto}).value(),
            picture_of(scene, {.walk = Walk::kTracking}).value());
}

TEST(Highlight, TintsMatterInItsSphereAndKeepsTheExactWalk) {
  volume::Volume plain = marked_volume();
  plain.label_set = {};
  diaphane::v1::Scene scene = scene_with({});
  auto& highlight = *scene.mutable_highlight();
  test::set(highlight.mutable_centre(), -4, 3, 2);
  highlight.set_radius(6);
  test::set(highlight.mutable_colour(), 0, 0, 1);
  highlight.set_strength(0.5);
  const test::Prepared p(plain, scene);
  EXPECT_TRUE(p.scene().features.has(Feature::kLabels));
  EXPECT_TRUE(use_exact_walk(p.scene(), Method{}));
  const auto albedo_at_world = [&](double x, double y, double z) {
    const auto& h = plain.header;
    const Float3 place =
        to_float(Double3{x / h.spacing[0] + 0.5 * h.size[0], y / h.spacing[1] + 0.5 * h.size[1],
                         z / h.spacing[2] + 0.5 * h.size[2]});
    return scatter_at<kAllFeatures>(p.view(), place, p.view().volume.at(place), {0, 1, 0}, 0.5f)
        .albedo;
  };
  // The reach is measured in mm, although voxels are longer along y than along z.
  for (const auto& [inside, y, z] : {std::tuple{true, 3 + 5.9, 2.0},
                                     {false, 3 + 6.1, 2.0},
                                     {true, 3.0, 2 - 5.9},
                                     {false, 3.0, 2 - 6.1}}) {
    const Float3 albedo = albedo_at_world(-4, y, z);
    EXPECT_NEAR(albedo.x, inside ? 0.4 : 0.8, 1e-6) << y << " " << z;
    EXPECT_NEAR(albedo.z, inside ? 0.9 : 0.8, 1e-6);
  }
}

TEST(Highlight, CostsNothingWhereThereIsNone) {
  diaphane::v1::Scene scene = scene_with({});
  EXPECT_FALSE(test::Prepared(marked_volume(), scene).scene().features.has(Feature::kLabels));
  scene.mutable_highlight()->set_radius(1);
  EXPECT_EQ(test::Prepared(marked_volume(), scene).scene().highlight.strength, 0.75f);
}

TEST(Labels, ChangedLooksTakeEffectWithTheSameTransferFunction) {
  const auto engine = make_cpu_engine(2);
  const auto loaded = engine->load(marked_volume()).value();
  const auto renderer = engine->renderer(loaded, 3, 0, {.walk = Walk::kTracking}).value();
  for (const double opacity : {0.5, 0.0, 1.0}) {
    const diaphane::v1::Scene scene = scene_with({opacity, opacity, 1});
    ASSERT_TRUE(renderer->set_scene(scene, {24, 24}));
    ASSERT_TRUE(renderer->render(4, nullptr));
    PictureRgbF out;
    ASSERT_TRUE(renderer->radiance(out));
    EXPECT_EQ(out.pixels, picture_of(scene, {.walk = Walk::kTracking}).value()) << opacity;
  }
}

TEST(Labels, ThatDoNotMatchTheVolumeAreRefused) {
  const auto engine = make_cpu_engine(1);
  volume::Volume volume = marked_volume();
  volume.label_set.labels.voxels.pop_back();
  EXPECT_EQ(engine->load(volume).error().field, "labels");
  volume = marked_volume();
  volume.label_set.table.pop_back();
  EXPECT_EQ(engine->load(volume).error().field, "labels");
}

}  // namespace
}  // namespace diaphane::render
