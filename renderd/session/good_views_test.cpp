#include "renderd/session/good_views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render {
namespace {

constexpr double kSide = 60;  // mm and voxels

diaphane::v1::Scene opaque_scene() {
  diaphane::v1::Scene scene;
  test::add_channel(*scene.mutable_transfer_function(), {{100, 0}, {200, 1}, {3000, 1}});
  scene.mutable_transfer_function()->set_extinction_per_mm(5);
  test::set_camera(scene, 0, -500, 0, 30);
  return scene;
}

std::shared_ptr<const CoarseVolume> matter(
    const std::function<bool(double, double, double)>& is_matter) {
  const auto side = static_cast<std::uint32_t>(kSide);
  return coarse_of(
      test::make_volume({side, side, side}, {1, 1, 1}, [&](double x, double y, double z) {
        const double m = kSide / 2;
        return is_matter(x - m, y - m, z - m) ? 1000 : 0;
      }));
}

const GoodView& best(const GoodViews& views) {
  return *std::ranges::max_element(views.views, {}, &GoodView::entropy);
}

TEST(GoodViews, ThinPlateIsSeenFromItsFaces) {
  // A sagittal plate, whose faces look to the patient's left and right.
  const auto plate = matter([](double x, double y, double z) {
    return std::abs(x) < 3 && std::abs(y) < 25 && std::abs(z) < 25;
  });
  const GoodViews views = good_views(*plate, opaque_scene());
  const double from_left = std::abs(best(views).azimuth);
  EXPECT_LE(std::min(from_left, 180 - from_left), 45);
}

TEST(GoodViews, SideWithDetailsIsBetterThanTheHiddenOne) {
  // Pegs on the front of a wall, which hides them from behind.
  const auto wall = matter([](double x, double y, double z) {
    if (std::abs(y - 10) < 3) return std::abs(x) < 28 && std::abs(z) < 28;
    return y > -15 && y < 10 && std::fmod(x + 60, 12) < 5 && std::fmod(z + 60, 12) < 5;
  });
  const GoodViews views = good_views(*wall, opaque_scene());
  // The front is at -90 degrees.
  EXPECT_LT(std::abs(best(views).azimuth + 90), 90);
}

TEST(GoodViews, AreFiveToEightAllAround) {
  const auto ball =
      matter([](double x, double y, double z) { return x * x + y * y + z * z < 400; });
  for (const auto& volume : {ball, matter([](double x, double, double) { return x > 10; })}) {
    const auto views = good_views(*volume, opaque_scene()).views;
    ASSERT_GE(views.size(), 5U);
    ASSERT_LE(views.size(), 8U);
    for (std::size_t i = 0; i < views.size(); ++i) {
      const GoodView& next = views[(i + 1) % views.size()];
      const double apart = std::fmod(next.azimuth - views[i].azimuth + 360, 360);
      EXPECT_GE(apart, 45);
      EXPECT_LE(apart, 75);
    }
  }
}

TEST(GoodViews, BoxEnclosesTheMatterTightly) {
  const auto brick = matter([](double x, double y, double z) {
    return std::abs(x - 5) < 10 && std::abs(y) < 15 && std::abs(z + 5) < 20;
  });
  const GoodViews views = good_views(*brick, opaque_scene());
  // Interpolation spreads matter by a voxel, and a cell is a 32nd of the longest side.
  const double tolerance = 1 + 2 * 42.0 / 32;
  const auto encloses = [&](double low, double high, double from, double to) {
    EXPECT_LE(low, from);
    EXPECT_GE(low, from - tolerance);
    EXPECT_GE(high, to);
    EXPECT_LE(high, to + tolerance);
  };
  encloses(views.low.x, views.high.x, -5, 15);
  encloses(views.low.y, views.high.y, -15, 15);
  encloses(views.low.z, views.high.z, -25, 15);
}

TEST(GoodViews, CutMatterDoesNotCount) {
  const auto ball =
      matter([](double x, double y, double z) { return x * x + y * y + z * z < 625; });
  diaphane::v1::Scene cut = opaque_scene();
  test::set(cut.mutable_clip()->mutable_box_low(), -30, -30, -30);
  test::set(cut.mutable_clip()->mutable_box_high(), 30, 30, 0);
  const GoodViews views = good_views(*ball, cut);
  EXPECT_LT(views.high.z, 3);
  EXPECT_LT(views.low.z, -23);
}

TEST(GoodViews, FindsViewsOfThinSlices) {
  const auto ball =
      matter([](double x, double y, double z) { return x * x + y * y + z * z < 625; });
  for (const double thickness : {3.0, 0.5}) {
    for (double low = -9; low < -6; low += 0.4) {
      diaphane::v1::Scene cut = opaque_scene();
      test::set(cut.mutable_clip()->mutable_box_low(), -30, -30, low);
      test::set(cut.mutable_clip()->mutable_box_high(), 30, 30, low + thickness);
      const GoodViews views = good_views(*ball, cut);
      ASSERT_GE(views.views.size(), 5U) << thickness << " mm from " << low;
      EXPECT_NEAR(views.low.z, low, 0.01);
      EXPECT_NEAR(views.high.z, low + thickness, 0.01);
    }
  }
}

TEST(GoodViews, BoxEndsAtAnObliqueCut) {
  const auto ball =
      matter([](double x, double y, double z) { return x * x + y * y + z * z < 625; });
  diaphane::v1::Scene cut = opaque_scene();
  auto& plane = *cut.mutable_clip()->add_planes();
  test::set(plane.mutable_point(), -10, -10, 0);
  test::set(plane.mutable_normal(), 1, 1, 0);
  const GoodViews views = good_views(*ball, cut);
  ASSERT_GE(views.views.size(), 5U);
  // The ball without the plane would reach x = 25. Of x + y = -20, it reaches x = 4.6, where
  // y = -24.6. A cell is at most 2 mm wide.
  EXPECT_LT(views.high.x, 4.6 + 1 + 2 * 2);
  EXPECT_LT(views.low.x, -22);
}

TEST(GoodViews, NothingVisibleHasNone) {
  const auto nothing = matter([](double, double, double) { return false; });
  const GoodViews views = good_views(*nothing, opaque_scene());
  EXPECT_TRUE(views.views.empty());
  EXPECT_FALSE(to_proto(views).has_low());
}

}  // namespace
}  // namespace diaphane::render
