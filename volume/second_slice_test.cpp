#include "volume/second_slice.h"

#include <gtest/gtest.h>

namespace diaphane::volume {
namespace {

/// A volume whose values tell the patient coordinates of their centres: x + 10 y + 100 z.
Volume located(std::array<std::uint32_t, 3> size, std::array<double, 3> spacing,
               std::array<double, 3> origin) {
  Volume volume;
  volume.header.size = size;
  volume.header.spacing = spacing;
  volume.header.origin = origin;
  for (std::uint32_t z = 0; z < size[2]; ++z) {
    for (std::uint32_t y = 0; y < size[1]; ++y) {
      for (std::uint32_t x = 0; x < size[0]; ++x) {
        volume.voxels.push_back(static_cast<std::int16_t>(origin[0] + x * spacing[0] +
                                                          10 * (origin[1] + y * spacing[1]) +
                                                          100 * (origin[2] + z * spacing[2])));
      }
    }
  }
  measure(volume);
  return volume;
}

TEST(SecondSlice, HasTheValuesOfTheSamePlacesInThePatient) {
  const Volume first = located({20, 20, 20}, {1, 1, 1}, {-10, -12, 3});
  const Volume second = located({8, 8, 8}, {2, 2, 2}, {-6, -8, 5});
  for (const Plane plane : kPlanes) {
    const SliceStack stack = plan_stack(first.header, plane);
    const auto shown = slice_of(first, stack, 9).value();
    const auto values = second_slice(first.header, pixels_of(stack, 9), second, kIdentity, shown);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i] == kBlank) continue;
      ++inside;
      // At the border, the outermost voxels continue for half a voxel of each axis.
      EXPECT_NEAR(values[i], shown[i], 111.5);
    }
    // The second scan covers 16 mm of 20 mm along each axis.
    EXPECT_GE(inside, 16u * 16) << static_cast<int>(plane);
    EXPECT_LE(inside, 17u * 17);
    const std::size_t middle = 9 + 20 * 9;
    EXPECT_EQ(values[middle], shown[middle]);
  }
}

TEST(SecondSlice, FollowsTheAlignmentAndHidesWhatIsHidden) {
  const Volume first = located({20, 20, 20}, {1, 1, 1}, {0, 0, 0});
  const Volume second = located({20, 20, 20}, {1, 1, 1}, {500, 0, 0});
  Matrix to_first = kIdentity;
  to_first[3] = -500;
  const SliceStack stack = plan_stack(first.header, Plane::kAxial);
  auto shown = slice_of(first, stack, 4).value();
  shown[25] = kBlank;
  const auto values = second_slice(first.header, pixels_of(stack, 4), second, to_first, shown);
  EXPECT_EQ(values[25], kBlank);
  EXPECT_EQ(values[26], shown[26] + 500);
  const auto far = second_slice(first.header, pixels_of(stack, 4), second, kIdentity, shown);
  EXPECT_EQ(far[26], kBlank) << "the scans lie 500 mm apart";
}

TEST(SecondSlice, SamplesObliquePlanes) {
  const Volume first = located({20, 20, 20}, {1, 1, 1}, {0, 0, 0});
  ObliqueSlice slice;
  slice.columns = slice.rows = 5;
  slice.first = {-2, -2, -2};
  slice.right = {0.6, 0.8, 0};
  slice.down = {0, 0, 1};
  const auto shown = sample(first, slice);
  EXPECT_EQ(second_slice(first.header, pixels_of(slice), first, kIdentity, shown), shown);
}

}  // namespace
}  // namespace diaphane::volume
