#include "renderd/scene/framing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "renderd/scene/presets.h"

namespace diaphane::render {
namespace {

using Inside = std::function<bool(double x, double y, double z)>;

/// A CT of 60 x 50 x 40 voxels of 2 x 2 x 3 mm: soft tissue where `inside` says so, by indices,
/// and air elsewhere.
volume::Volume ct(const Inside& inside) {
  volume::Volume volume;
  volume.header.size = {60, 50, 40};
  volume.header.spacing = {2, 2, 3};
  volume.header.modality = volume::Modality::kCt;
  for (std::uint32_t z = 0; z < 40; ++z) {
    for (std::uint32_t y = 0; y < 50; ++y) {
      for (std::uint32_t x = 0; x < 60; ++x) {
        volume.voxels.push_back(inside(x + 0.5, y + 0.5, z + 0.5) ? 40 : -1000);
      }
    }
  }
  volume::measure(volume);
  return volume;
}

bool block(double x, double y, double z) {
  return x > 10 && x < 30 && y > 20 && y < 45 && z > 4 && z < 24;
}

void expect_near(const std::array<double, 3>& found, const std::array<double, 3>& expected) {
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(found[axis], expected[axis], 1e-9);
}

TEST(Framing, EnclosesTheBody) {
  const Framing framing = visible_part(ct(block));
  expect_near(framing.half_width, {20, 25, 30});
  expect_near(framing.centre, {-20, 15, -18});
}

TEST(Framing, FollowsTheAxesOfTheScan) {
  volume::Volume volume = ct(block);
  volume.header.direction = {0, -1, 0, 1, 0, 0, 0, 0, 1};  // x to the back, y to the right
  expect_near(visible_part(volume).centre, {-15, -20, -18});
}

TEST(Framing, IgnoresSpecksOfNoise) {
  const auto with_specks = [](double x, double y, double z) {
    return block(x, y, z) || (x > 58 && y < 2 && z > 38);
  };
  expect_near(visible_part(ct(with_specks)).half_width, {20, 25, 30});
}

TEST(Framing, ShowsTheWholeBoxOfAScanWithoutABody) {
  const volume::Volume air = ct([](double, double, double) { return false; });
  expect_near(visible_part(air).half_width, whole_box(air.header).half_width);
  expect_near(visible_part(air).centre, {0, 0, 0});
}

TEST(Framing, BringsTheCameraOfEveryPresetToTheBody) {
  const volume::Volume volume = ct(block);
  const Framing framing = visible_part(volume);
  for (const auto& preset : presets_for(volume.header, framing, true)) {
    const auto& camera = preset.scene().camera();
    EXPECT_NEAR(camera.target().x(), framing.centre[0], 1e-9) << preset.name();
    EXPECT_NEAR(camera.target().y(), framing.centre[1], 1e-9) << preset.name();
    const auto& eye = camera.eye();
    const double away = std::hypot(eye.x() - camera.target().x(), eye.y() - camera.target().y(),
                                   eye.z() - camera.target().z());
    const double half_height =
        away * std::tan(0.5 * camera.vertical_fov_degrees() * std::acos(-1.) / 180);
    EXPECT_GT(half_height, 30) << preset.name() << ": the block fits the picture";
    EXPECT_LT(half_height, 60) << preset.name() << ": the block fills half of it";
  }
}

}  // namespace
}  // namespace diaphane::render
