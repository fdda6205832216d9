#include "renderd/session/depth.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render {
namespace {

using test::set;

// Seen from the front, a place at y in the volume is 500 + y mm away.
constexpr double kEye = 500;
constexpr Canvas kCanvas{400, 300};

diaphane::v1::Scene from_the_front(double extinction = 5) {
  diaphane::v1::Scene scene;
  test::add_channel(*scene.mutable_transfer_function(), {{100, 0}, {200, 1}, {3000, 1}});
  scene.mutable_transfer_function()->set_extinction_per_mm(extinction);
  test::set_camera(scene, 0, -kEye, 0, 30);
  return scene;
}

/// A cube of 100 mm with `value` of y, in mm from its front.
std::shared_ptr<const CoarseVolume> layers(std::uint32_t side,
                                           const std::function<double(double)>& value) {
  const double spacing = 100.0 / side;
  return coarse_of(test::make_volume({side, side, side}, {spacing, spacing, spacing},
                                     [&](double, double y, double) { return value(y * spacing); }));
}

double opaque_from_30(double y) { return y > 30 ? 1000 : 0; }

TEST(Depth, IsThatOfTheSurfaceUnderThePoint) {
  const auto volume = layers(100, opaque_from_30);
  const auto visible = visible_point_at(*volume, from_the_front(), kCanvas, 0.5, 0.5);
  ASSERT_TRUE(visible);
  EXPECT_NEAR(visible->distance, kEye - 50 + 30, 1);
  EXPECT_NEAR(visible->place.y, -50 + 30, 1);
}

TEST(Depth, IsMeasuredAlongTheViewAxisOffCentre) {
  const auto volume = layers(100, opaque_from_30);
  // 30 degrees at 480 mm are 257 mm high, so a tenth of the height is 25.7 mm.
  const auto visible =
      visible_point_at(*volume, from_the_front(), kCanvas, 0.5 + 0.1 * 300 / 400, 0.4);
  ASSERT_TRUE(visible);
  EXPECT_NEAR(visible->distance, kEye - 20, 1);
  EXPECT_NEAR(visible->place.x, 25.7, 0.3) << "the patient's left is on the right";
  EXPECT_NEAR(visible->place.z, 25.7, 0.3);
}

TEST(Depth, IsAccurateForVolumesOfUnequalSides) {
  // 100 mm from the front to the back, and 50 mm across.
  const auto volume = coarse_of(test::make_volume(
      {50, 100, 50}, {1, 1, 1}, [](double, double y, double) { return opaque_from_30(y); }));
  const auto visible = visible_point_at(*volume, from_the_front(), kCanvas, 0.5, 0.5);
  ASSERT_TRUE(visible);
  EXPECT_NEAR(visible->distance, kEye - 50 + 30, 1);
}

TEST(Depth, LooksThroughHiddenLabels) {
  volume::Volume volume = test::make_volume(
      {100, 100, 100}, {1, 1, 1}, [](double, double y, double) { return opaque_from_30(y); });
  test::mark(volume, [](std::uint32_t, std::uint32_t y, std::uint32_t) { return y < 60 ? 1 : 0; });
  const auto coarse = coarse_of(volume);
  diaphane::v1::Scene scene = from_the_front();
  EXPECT_NEAR(visible_point_at(*coarse, scene, kCanvas, 0.5, 0.5)->distance, kEye - 20, 1);
  scene.add_labels()->set_number(10);
  scene.mutable_labels(0)->set_opacity(0);
  EXPECT_NEAR(visible_point_at(*coarse, scene, kCanvas, 0.5, 0.5)->distance, kEye + 10, 1);
  scene.mutable_labels(0)->clear_opacity();
  scene.mutable_labels(0)->set_solo(true);
  EXPECT_NEAR(visible_point_at(*coarse, scene, kCanvas, 0.5, 0.5)->distance, kEye - 20, 1);
}

TEST(Depth, IsAccurateForDownsampledVolumes) {
  const auto volume = layers(250, opaque_from_30);
  EXPECT_LE(volume->volume.voxels.size(), 1'000'000U);
  const auto visible = visible_point_at(*volume, from_the_front(), kCanvas, 0.5, 0.5);
  ASSERT_TRUE(visible);
  EXPECT_NEAR(visible->distance, kEye - 20, 1);
}

TEST(Depth, IsThatOfSkinOrBoneButNeverBetween) {
  // The skin is 4 mm thick and 10 mm from the front, and the bone starts at 60 mm.
  const auto volume = layers(100, [](double y) {
    return y > 60 ? 1000 : y > 10 && y < 14 ? 150 : 0;  // half as opaque
  });
  const auto thick = visible_point_at(*volume, from_the_front(2), kCanvas, 0.5, 0.5);
  ASSERT_TRUE(thick);
  EXPECT_NEAR(thick->distance, kEye - 50 + 11, 2);
  const auto thin = visible_point_at(*volume, from_the_front(0.1), kCanvas, 0.5, 0.5);
  ASSERT_TRUE(thin);
  EXPECT_GE(thin->distance, kEye - 50 + 59);
}

TEST(Depth, IsEmptyForBackground) {
  const auto volume = layers(50, opaque_from_30);
  EXPECT_FALSE(visible_point_at(*volume, from_the_front(), kCanvas, 0.01, 0.5))
      << "beside the volume";
  EXPECT_FALSE(
      visible_point_at(*layers(50, [](double) { return 0; }), from_the_front(), kCanvas, 0.5, 0.5));
}

TEST(Depth, IgnoresClippedRegions) {
  const auto volume = layers(100, opaque_from_30);
  diaphane::v1::Scene scene = from_the_front();
  set(scene.mutable_clip()->mutable_box_low(), -50, 10, -50);
  set(scene.mutable_clip()->mutable_box_high(), 50, 50, 50);
  const auto visible = visible_point_at(*volume, scene, kCanvas, 0.5, 0.5);
  ASSERT_TRUE(visible);
  EXPECT_NEAR(visible->distance, kEye + 10, 1);
}

TEST(Depth, IncludesSlicesInEmptySpace) {
  const auto volume = layers(100, opaque_from_30);
  diaphane::v1::Scene scene = from_the_front();
  scene.mutable_slices()->mutable_coronal()->set_shown(true);
  scene.mutable_slices()->mutable_coronal()->set_position(-40);
  scene.mutable_slices()->set_window_width(400);
  for (const bool alone : {false, true}) {
    scene.mutable_slices()->set_alone(alone);
    const auto visible = visible_point_at(*volume, scene, kCanvas, 0.5, 0.5);
    ASSERT_TRUE(visible) << alone;
    EXPECT_NEAR(visible->distance, kEye - 40, 1e-2) << alone;
  }
}

TEST(Depth, IsMeasuredFromTheEyeForParallelRaysAndOpenLens) {
  const auto volume = layers(100, opaque_from_30);
  diaphane::v1::Scene scene = from_the_front();
  scene.mutable_camera()->set_orthographic_height(200);
  scene.mutable_camera()->set_aperture_radius(20);
  scene.mutable_camera()->set_focal_distance(100);
  const auto visible = visible_point_at(*volume, scene, kCanvas, 0.5, 0.4);
  ASSERT_TRUE(visible);
  EXPECT_NEAR(visible->distance, kEye - 20, 1);
  EXPECT_NEAR(visible->place.z, 20, 0.5);
}

TEST(HiddenPlaces, AreThoseBehindMatter) {
  const auto volume = layers(100, opaque_from_30);
  const auto hidden = [&](const diaphane::v1::Scene& scene) {
    return hidden_places(*volume, scene, kCanvas,
                         {{0, -45, 0}, {0, -20, 0}, {25, -20, 25}, {0, 0, 0}, {300, 0, 0}});
  };
  const std::vector<bool> expected{false, false, false, true, false};
  EXPECT_EQ(hidden(from_the_front()), expected) << "before, on, on, in and beside the matter";
  diaphane::v1::Scene flat = from_the_front();
  flat.mutable_camera()->set_orthographic_height(200);
  EXPECT_EQ(hidden(flat), expected);
  diaphane::v1::Scene behind = from_the_front();
  test::set_camera(behind, 0, kEye, 0, 30);
  EXPECT_EQ(hidden(behind), (std::vector<bool>{true, true, true, true, false}));
  EXPECT_EQ(hidden(from_the_front(0.001)), std::vector<bool>(5)) << "it is nearly transparent";
  diaphane::v1::Scene cut = from_the_front();
  set(cut.mutable_clip()->mutable_box_low(), -50, 10, -50);
  set(cut.mutable_clip()->mutable_box_high(), 50, 50, 50);
  EXPECT_EQ(hidden(cut), std::vector<bool>(5)) << "what was cut away hides nothing";
}

TEST(HiddenPlaces, AreAlsoThoseBehindASlice) {
  const auto volume = layers(100, opaque_from_30);
  diaphane::v1::Scene scene = from_the_front();
  scene.mutable_slices()->mutable_coronal()->set_shown(true);
  scene.mutable_slices()->mutable_coronal()->set_position(-40);
  scene.mutable_slices()->set_window_width(400);
  EXPECT_EQ(hidden_places(*volume, scene, kCanvas, {{0, -45, 0}, {0, -40, 0}, {0, -30, 0}}),
            (std::vector<bool>{false, false, true}));
}

TEST(HiddenPlaces, NeverIncludeAPlaceThatIsVisible) {
  const auto volume = layers(250, opaque_from_30);
  for (const double x : {0.42, 0.45, 0.5, 0.55}) {
    const auto visible = visible_point_at(*volume, from_the_front(), kCanvas, x, 0.4);
    ASSERT_TRUE(visible);
    EXPECT_EQ(hidden_places(*volume, from_the_front(), kCanvas, {visible->place}),
              std::vector<bool>(1));
  }
}

}  // namespace
}  // namespace diaphane::render
