#include "renderd/session/kept_voxels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "volume/slices.h"

namespace diaphane::render {
namespace {

void set(v1::Vec3& out, double x, double y, double z) {
  out.set_x(x);
  out.set_y(y);
  out.set_z(z);
}

struct KeptVoxelsTest : testing::Test {
  KeptVoxelsTest() {
    volume.header.size = {12, 10, 8};
    volume.header.spacing = {1, 2, 3};
    for (std::int16_t i = 0; i < 12 * 10 * 8; ++i) volume.voxels.push_back(i);
    volume::measure(volume);
  }
  /// Returns the centre of a voxel in mm in world space.
  volume::Vector centre(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    const std::array<double, 3> index{x + 0.5, y + 0.5, z + 0.5};
    volume::Vector place{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t v = 0; v < 3; ++v) {
        place[axis] += volume.header.direction[3 * axis + v] * volume.header.spacing[v] *
                       (index[v] - volume.header.size[v] / 2.0);
      }
    }
    return place;
  }
  /// As scene.proto defines it: inside the box and behind every plane.
  bool inside(const volume::Vector& p) const {
    constexpr double kRounding = 1e-6;
    if (clip.has_box_low()) {
      const auto& low = clip.box_low();
      const auto& high = clip.box_high();
      if (p[0] < low.x() - kRounding || p[1] < low.y() - kRounding || p[2] < low.z() - kRounding ||
          p[0] > high.x() + kRounding || p[1] > high.y() + kRounding ||
          p[2] > high.z() + kRounding) {
        return false;
      }
    }
    for (const auto& plane : clip.planes()) {
      const auto& n = plane.normal();
      const auto& q = plane.point();
      const double length = std::sqrt(n.x() * n.x() + n.y() * n.y() + n.z() * n.z());
      const double before =
          ((p[0] - q.x()) * n.x() + (p[1] - q.y()) * n.y() + (p[2] - q.z()) * n.z()) / length;
      if (before > kRounding) return false;
    }
    return true;
  }
  /// Checks every voxel, and returns how many are kept.
  int check() const {
    const volume::KeptVoxels kept = kept_by(volume.header, clip);
    int count = 0;
    for (std::uint32_t z = 0; z < volume.header.size[2]; ++z) {
      for (std::uint32_t y = 0; y < volume.header.size[1]; ++y) {
        for (std::uint32_t x = 0; x < volume.header.size[0]; ++x) {
          const bool keeps = kept.keeps(x, y, z);
          EXPECT_EQ(keeps, inside(centre(x, y, z))) << x << ' ' << y << ' ' << z;
          count += keeps;
        }
      }
    }
    return count;
  }
  /// Checks all slices of all planes: each pixel is blank or its voxel's value, as it should be.
  void check_slices() const {
    const volume::KeptVoxels kept = kept_by(volume.header, clip);
    for (const volume::Plane plane : volume::kPlanes) {
      const volume::SliceStack stack = volume::plan_stack(volume.header, plane);
      for (std::uint32_t index = 0; index < stack.slices; ++index) {
        const auto whole = volume::slice_of(volume, stack, index);
        const auto clipped = volume::clipped_slice_of(volume, stack, index, kept);
        ASSERT_TRUE(whole && clipped);
        ASSERT_EQ(clipped->size(), stack.pixels());
        for (std::size_t i = 0; i < clipped->size(); ++i) {
          // The value of a voxel is its number.
          const auto number = static_cast<std::uint32_t>((*whole)[i]);
          const bool keeps = kept.keeps(number % 12, number / 12 % 10, number / 120);
          EXPECT_EQ((*clipped)[i], keeps ? (*whole)[i] : volume::kBlank);
        }
      }
    }
  }

  volume::Volume volume;
  v1::Clip clip;
};

TEST_F(KeptVoxelsTest, KeepsAllWithoutAClip) {
  EXPECT_EQ(check(), 12 * 10 * 8);
  check_slices();
}

TEST_F(KeptVoxelsTest, BoxKeepsVoxelsWithCentresInsideOrOnItsBorder) {
  set(*clip.mutable_box_low(), -2.5, -3, -1.5);  // exactly at centres
  set(*clip.mutable_box_high(), 2.5, 3, 1.5);
  EXPECT_EQ(check(), 6 * 4 * 2);
  check_slices();
  set(*clip.mutable_box_low(), -2.49, -2.99, -1.49);  // a hundredth further inside
  set(*clip.mutable_box_high(), 2.49, 2.99, 1.49);
  EXPECT_EQ(check(), 4 * 2 * 0);
  check_slices();
}

TEST_F(KeptVoxelsTest, PlanesKeepVoxelsBehindAllOfThem) {
  for (int degrees = 0; degrees < 360; degrees += 17) {
    clip.Clear();
    const double a = degrees * std::numbers::pi / 180;
    auto& one = *clip.add_planes();
    set(*one.mutable_point(), 1, -0.5, 0.7);
    set(*one.mutable_normal(), 3 * std::cos(a), 3 * std::sin(a), 1.3);
    auto& other = *clip.add_planes();
    set(*other.mutable_point(), -2, 1, 0);
    set(*other.mutable_normal(), std::sin(a), -0.2, -std::cos(a));
    const int count = check();
    EXPECT_GT(count, 0);
    EXPECT_LT(count, 12 * 10 * 8);
    check_slices();
  }
}

TEST_F(KeptVoxelsTest, SupportsRotatedVolumes) {
  const double c = std::cos(0.5), s = std::sin(0.5);
  volume.header.direction = {c, -s, 0, s, c, 0, 0, 0, 1};
  set(*clip.mutable_box_low(), -4, -3, -6);
  set(*clip.mutable_box_high(), 3, 5, 6);
  auto& plane = *clip.add_planes();
  set(*plane.mutable_point(), 0, 0, 2);
  set(*plane.mutable_normal(), 0.3, 0.1, 1);
  EXPECT_GT(check(), 0);
  // A pixel shows the voxel that contains its centre, and is kept or blank by the centre of that
  // voxel.
  const volume::KeptVoxels kept = kept_by(volume.header, clip);
  for (const volume::Plane across : volume::kPlanes) {
    const volume::SliceStack stack = volume::plan_stack(volume.header, across);
    for (std::uint32_t index = 0; index < stack.slices; ++index) {
      const auto values = volume::clipped_slice_of(volume, stack, index, kept);
      ASSERT_TRUE(values);
      for (const std::int16_t value : *values) {
        if (value == volume::kBlank) continue;
        const auto number = static_cast<std::uint32_t>(value);
        EXPECT_TRUE(inside(centre(number % 12, number / 12 % 10, number / 120)));
      }
    }
  }
}

TEST_F(KeptVoxelsTest, KeepsNoneForAPlaneWithoutNormal) {
  set(*clip.add_planes()->mutable_point(), 0, 0, 0);  // without a normal, which check_scene refuses
  const volume::KeptVoxels kept = kept_by(volume.header, clip);
  EXPECT_FALSE(kept.keeps(5, 5, 5));
}

}  // namespace
}  // namespace diaphane::render
