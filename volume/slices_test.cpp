#include "volume/slices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace diaphane::volume {
namespace {

// Each voxel has a different value.
Volume numbered(std::array<std::uint32_t, 3> size, std::array<double, 3> spacing,
                std::array<double, 9> direction) {
  Volume volume;
  volume.header.size = size;
  volume.header.spacing = spacing;
  volume.header.direction = direction;
  for (std::uint64_t i = 0; i < volume.header.voxel_count(); ++i) {
    volume.voxels.push_back(static_cast<std::int16_t>(i) - 500);
  }
  measure(volume);
  return volume;
}

std::array<double, 3> place(const SliceStack& stack, double column, double row, double slice) {
  std::array<double, 3> world{};
  for (std::size_t k = 0; k < 3; ++k) {
    world[k] =
        stack.first[k] + column * stack.right[k] + row * stack.down[k] + slice * stack.next[k];
  }
  return world;
}

// Returns the centre of a voxel, computed only from the header's definition.
std::array<double, 3> centre(const Header& header, std::array<std::uint32_t, 3> voxel) {
  std::array<double, 3> world{};
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t a = 0; a < 3; ++a) {
      world[k] +=
          header.direction[3 * k + a] * (voxel[a] + 0.5 - header.size[a] / 2.0) * header.spacing[a];
    }
  }
  return world;
}

constexpr std::array<double, 9> kIdentity{1, 0, 0, 0, 1, 0, 0, 0, 1};

/// Covers all 24 orientations in which a stored volume (determinant +1) can lie along the patient's
/// axes. Every voxel appears in exactly one pixel of every plane, at its own position.
TEST(Slices, AxisAlignedPixelsEqualTheirVoxels) {
  int ways = 0;
  const std::array<std::array<std::size_t, 3>, 6> orders{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  for (std::size_t order = 0; order < orders.size(); ++order) {
    for (int signs = 0; signs < 8; ++signs) {
      const bool odd_order = order == 1 || order == 2 || order == 5;
      const int negative = (signs & 1) + (signs >> 1 & 1) + (signs >> 2 & 1);
      if (odd_order == (negative % 2 == 0)) continue;  // determinant -1
      std::array<double, 9> direction{};
      for (std::size_t a = 0; a < 3; ++a) {
        direction[3 * orders[order][a] + a] = (signs >> a & 1) != 0 ? -1 : 1;
      }
      ++ways;
      const Volume volume = numbered({7, 5, 3}, {0.7, 1.1, 2.5}, direction);
      for (const Plane plane : kPlanes) {
        const SliceStack stack = plan_stack(volume.header, plane);
        ASSERT_EQ(stack.pixels() * stack.slices, volume.voxels.size());
        std::size_t found = 0;
        for (std::uint32_t z = 0; z < 3; ++z) {
          for (std::uint32_t y = 0; y < 5; ++y) {
            for (std::uint32_t x = 0; x < 7; ++x) {
              const auto at = centre(volume.header, {x, y, z});
              const auto along = [&](const std::array<double, 3>& step) {
                double dot = 0, square = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                  dot += (at[k] - stack.first[k]) * step[k];
                  square += step[k] * step[k];
                }
                return dot / square;
              };
              const double column = along(stack.right), row = along(stack.down),
                           slice = along(stack.next);
              ASSERT_NEAR(column, std::round(column), 1e-9);
              ASSERT_NEAR(row, std::round(row), 1e-9);
              ASSERT_NEAR(slice, std::round(slice), 1e-9);
              const auto values =
                  slice_of(volume, stack, static_cast<std::uint32_t>(std::lround(slice)));
              ASSERT_TRUE(values);
              const auto pixel = static_cast<std::size_t>(std::lround(row)) * stack.columns +
                                 static_cast<std::size_t>(std::lround(column));
              found += (*values)[pixel] == volume.voxels[x + 7 * (y + 5 * z)];
            }
          }
        }
        EXPECT_EQ(found, volume.voxels.size());
      }
    }
  }
  EXPECT_EQ(ways, 24);
}

TEST(Slices, FollowRadiologicalOrientation) {
  const Volume volume = numbered({6, 4, 5}, {1, 2, 3}, kIdentity);
  const SliceStack axial = plan_stack(volume.header, Plane::kAxial);
  EXPECT_EQ(axial.columns, 6U);
  EXPECT_EQ(axial.rows, 4U);
  EXPECT_EQ(axial.slices, 5U);
  EXPECT_EQ(axial.right, (std::array<double, 3>{1, 0, 0}));  // towards the patient's left
  EXPECT_EQ(axial.down, (std::array<double, 3>{0, 2, 0}));   // towards the back
  EXPECT_EQ(axial.next, (std::array<double, 3>{0, 0, 3}));   // towards the head
  EXPECT_EQ(axial.first, (std::array<double, 3>{-2.5, -3, -6}));
  const SliceStack coronal = plan_stack(volume.header, Plane::kCoronal);
  EXPECT_EQ(coronal.right, (std::array<double, 3>{1, 0, 0}));
  EXPECT_EQ(coronal.down, (std::array<double, 3>{0, 0, -3}));  // towards the feet
  EXPECT_EQ(coronal.slices, 4U);
  const SliceStack sagittal = plan_stack(volume.header, Plane::kSagittal);
  EXPECT_EQ(sagittal.right, (std::array<double, 3>{0, 2, 0}));  // the front is at the left
  EXPECT_EQ(sagittal.down, (std::array<double, 3>{0, 0, -3}));
  EXPECT_EQ(sagittal.slices, 6U);
}

/// Axes that were rounded when they were written still count as the patient's.
TEST(Slices, ToleratesRoundedAxes) {
  std::array<double, 9> direction = kIdentity;
  direction[1] = 3e-5;
  direction[3] = -3e-5;
  const Volume volume = numbered({40, 30, 4}, {0.5, 0.5, 2}, direction);
  const SliceStack stack = plan_stack(volume.header, Plane::kAxial);
  for (std::uint32_t z = 0; z < 4; ++z) {
    const auto values = slice_of(volume, stack, z);
    ASSERT_TRUE(values);
    EXPECT_TRUE(std::equal(values->begin(), values->end(), volume.voxels.begin() + 40 * 30 * z));
  }
}

/// Every pixel, except where rounding decides, has the value of the voxel that contains its centre,
/// and the minimum outside the box.
TEST(Slices, ObliquePixelsTakeTheVoxelThatContainsThem) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int turn = 0; turn < 4; ++turn) {
    double q[4], n = 0;
    for (double& part : q) n += (part = normal(random)) * part;
    n = std::sqrt(n);
    const double w = q[0] / n, x = q[1] / n, y = q[2] / n, z = q[3] / n;
    const Volume volume =
        numbered({9, 7, 5}, {0.8, 1.0, 1.9},
                 {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                  2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                  2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)});
    const Header& header = volume.header;
    for (const Plane plane : kPlanes) {
      const SliceStack stack = plan_stack(header, plane);
      std::size_t looked = 0, inside = 0;
      for (std::uint32_t slice = 0; slice < stack.slices; ++slice) {
        const auto values = slice_of(volume, stack, slice);
        ASSERT_TRUE(values);
        for (std::uint32_t row = 0; row < stack.rows; ++row) {
          for (std::uint32_t column = 0; column < stack.columns; ++column) {
            const auto at = place(stack, column, row, slice);
            bool doubtful = false, within = true;
            std::array<std::int64_t, 3> voxel{};
            for (std::size_t a = 0; a < 3; ++a) {
              double along = 0;
              for (std::size_t k = 0; k < 3; ++k) along += header.direction[3 * k + a] * at[k];
              const double from_corner = along / header.spacing[a] + header.size[a] / 2.0;
              doubtful = doubtful || std::abs(from_corner - std::round(from_corner)) < 1e-9;
              voxel[a] = static_cast<std::int64_t>(std::floor(from_corner));
              within = within && voxel[a] >= 0 && voxel[a] < header.size[a];
            }
            if (doubtful) continue;
            ++looked;
            inside += within;
            const std::int32_t expected = within ? volume.voxels[static_cast<std::size_t>(
                                                       voxel[0] + 9 * (voxel[1] + 7 * voxel[2]))]
                                                 : header.minimum;
            ASSERT_EQ((*values)[std::size_t{row} * stack.columns + column], expected);
          }
        }
      }
      EXPECT_GT(looked, 300U);
      EXPECT_GT(inside, 100U);
    }
  }
}

TEST(Slices, ObliqueSlicesCoverTheBoxWithBoundedSize) {
  const double c = std::cos(0.5), s = std::sin(0.5);
  Header header;
  header.size = {2000, 2000, 3};
  header.spacing = {0.1, 0.1, 5};
  header.direction = {c, -s, 0, s, c, 0, 0, 0, 1};
  const SliceStack stack = plan_stack(header, Plane::kAxial);
  EXPECT_EQ(stack.columns, kMostOblique);
  EXPECT_NEAR(stack.right[0] * stack.columns, 200 * (c + s), 1e-9);
  EXPECT_EQ(stack.slices, 3U);
  EXPECT_DOUBLE_EQ(stack.next[2], 5);
}

TEST(Slices, RefusesIndexOutOfRange) {
  const Volume volume = numbered({3, 4, 5}, {1, 1, 1}, kIdentity);
  const SliceStack stack = plan_stack(volume.header, Plane::kAxial);
  EXPECT_TRUE(slice_of(volume, stack, 4));
  const auto beyond = slice_of(volume, stack, 5);
  ASSERT_FALSE(beyond);
  EXPECT_EQ(beyond.error().code, ErrorCode::kInvalid);
}

}  // namespace
}  // namespace diaphane::volume
