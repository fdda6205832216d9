#include "volume/slice_interpolation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>

#include "volume/slice_motion.h"

namespace diaphane::volume {
namespace {

using Shape = std::function<double(double x, double y, double z)>;

/// A volume of side x side pixels of 1 mm and `slices` slices `apart` mm apart, whose values are
/// those of the shape, in mm from the corner of the box.
Volume volume_of(const Shape& shape, std::uint32_t side, std::uint32_t slices, double apart) {
  Volume volume;
  volume.header.size = {side, side, slices};
  volume.header.spacing = {1, 1, apart};
  for (std::uint32_t z = 0; z < slices; ++z) {
    for (std::uint32_t y = 0; y < side; ++y) {
      for (std::uint32_t x = 0; x < side; ++x) {
        volume.voxels.push_back(
            static_cast<std::int16_t>(std::lround(shape(x + 0.5, y + 0.5, (z + 0.5) * apart))));
      }
    }
  }
  measure(volume);
  return volume;
}

/// A ball of 1000 in air of -1000 whose border is as wide as two pixels, in a box of 96 mm.
double ball(double x, double y, double z) {
  const double out = std::hypot(x - 48, y - 48, z - 48) - 40;
  return -1000 * std::clamp(out, -1., 1.);
}

double rmse(const Volume& volume, const Shape& shape) {
  const Volume truth =
      volume_of(shape, volume.header.size[0], volume.header.size[2], volume.header.spacing[2]);
  double sum = 0;
  for (std::size_t i = 0; i < truth.voxels.size(); ++i) {
    sum += std::pow(volume.voxels[i] - truth.voxels[i], 2);
  }
  return std::sqrt(sum / static_cast<double>(truth.voxels.size()));
}

/// What interpolation straight across makes of the volume.
Volume linear(const Volume& stored, std::uint32_t refinement) {
  Volume result = stored;
  result.header.size[2] *= refinement;
  result.header.spacing[2] /= refinement;
  result.voxels.clear();
  const std::size_t pixels = std::size_t{stored.header.size[0]} * stored.header.size[1];
  for (std::uint32_t z = 0; z < result.header.size[2]; ++z) {
    const double at = std::clamp((z + 0.5) / refinement - 0.5, 0., stored.header.size[2] - 1.);
    const auto below = static_cast<std::size_t>(at);
    const std::size_t above = std::min<std::size_t>(below + 1, stored.header.size[2] - 1);
    for (std::size_t i = 0; i < pixels; ++i) {
      result.voxels.push_back(static_cast<std::int16_t>(
          std::lround(std::lerp(static_cast<double>(stored.voxels[below * pixels + i]),
                                static_cast<double>(stored.voxels[above * pixels + i]),
                                at - static_cast<double>(below)))));
    }
  }
  return result;
}

TEST(SliceInterpolation, IsNeededOnlyWhereSlicesAreFartherApartThanPixels) {
  Header header;
  header.size = {256, 256, 100};
  const auto refinement = [&](double pixel, double apart) {
    header.spacing = {pixel, pixel, apart};
    return refinement_of(header);
  };
  EXPECT_EQ(refinement(1, 1), 1U);
  EXPECT_EQ(refinement(1, 0.5), 1U);
  EXPECT_EQ(refinement(1, 1.2), 1U) << "steps of this height are not visible";
  EXPECT_EQ(refinement(0.957, 1.5), 2U);
  EXPECT_EQ(refinement(0.8, 2.4), 3U);
  EXPECT_EQ(refinement(0.7, 5), 8U);
  EXPECT_EQ(refinement(0.5, 10), kMaxRefinement);
  header.size[2] = 1;
  EXPECT_EQ(refinement(1, 5), 1U) << "there is nothing between";
}

TEST(SliceInterpolation, StaysWithinTheLimitOfVoxels) {
  Header header;
  header.spacing = {0.5, 0.5, 5};
  for (const std::uint32_t slices : {60U, 200U, 400U, 600U}) {
    header.size = {512, 512, slices};
    const std::uint32_t refinement = refinement_of(header);
    EXPECT_TRUE(refinement == 1 || header.voxel_count() * refinement <= kMaxRefinedVoxels);
    if (refinement < kMaxRefinement) {
      EXPECT_GT(header.voxel_count() * (refinement + 1), kMaxRefinedVoxels);
    }
  }
}

TEST(SliceInterpolation, FillsTheSameBoxAndRemembersTheStoredSlices) {
  Volume volume = volume_of(ball, 96, 32, 3);
  const Header before = volume.header;
  refine_slices(volume, 3, 2);
  EXPECT_EQ(volume.header.size, (std::array<std::uint32_t, 3>{96, 96, 96}));
  EXPECT_EQ(volume.header.spacing, (std::array<double, 3>{1, 1, 1}));
  EXPECT_EQ(volume.voxels.size(), volume.header.voxel_count());
  EXPECT_EQ(refinement_of(volume.header), 1U);
  const Header stored = stored_header(volume.header);
  EXPECT_EQ(stored.size, before.size);
  EXPECT_EQ(stored.spacing, before.spacing);
  EXPECT_EQ(stored.interpolated, 1U);
}

TEST(SliceInterpolation, KeepsStoredSlicesWhereOneLies) {
  const Volume stored = volume_of(ball, 96, 32, 3);
  Volume volume = stored;
  refine_slices(volume, 3, 2);
  constexpr std::size_t kPixels = std::size_t{96} * 96;
  for (std::size_t z = 0; z < 32; ++z) {
    EXPECT_TRUE(std::equal(stored.voxels.begin() + z * kPixels,
                           stored.voxels.begin() + (z + 1) * kPixels,
                           volume.voxels.begin() + (3 * z + 1) * kPixels))
        << z;
  }
}

TEST(SliceInterpolation, HalvesTheErrorOfABall) {
  for (const std::uint32_t refinement : {2U, 3U, 4U}) {
    const Volume stored = volume_of(ball, 96, 96 / refinement, refinement);
    Volume volume = stored;
    refine_slices(volume, refinement, 2);
    // What lies beyond the stored slices, where nothing is interpolated, is air in both.
    EXPECT_LT(rmse(volume, ball), 0.5 * rmse(linear(stored, refinement), ball)) << refinement;
  }
}

TEST(SliceInterpolation, KeepsStructuresThatAreEqualInAllSlices) {
  const auto column = [](double x, double y, double) {
    return -1000 * std::clamp(std::hypot(x - 48, y - 48) - 20, -1., 1.);
  };
  Volume volume = volume_of(column, 96, 12, 4);
  refine_slices(volume, 4, 2);
  EXPECT_EQ(volume.voxels, volume_of(column, 96, 48, 1).voxels);
}

TEST(SliceInterpolation, LeavesAirUnchanged) {
  // Rods end and begin in each slice, so that motion between them is only apparent.
  const auto rods = [](double x, double y, double z) {
    const double shift = std::floor(z / 2) * 11;
    return std::fmod(x + shift, 17) < 5 && std::fmod(y + 2 * shift, 19) < 5 ? 1000 : -1000;
  };
  const Volume stored = volume_of(rods, 96, 8, 2);
  Volume volume = stored;
  refine_slices(volume, 2, 2);
  constexpr std::size_t kPixels = std::size_t{96} * 96;
  for (std::size_t z = 1; z < 15; ++z) {
    for (std::size_t i = 0; i < kPixels; ++i) {
      const std::size_t below = (z - 1) / 2;
      if (stored.voxels[below * kPixels + i] < 0 && stored.voxels[(below + 1) * kPixels + i] < 0) {
        ASSERT_EQ(volume.voxels[z * kPixels + i], -1000) << z << ' ' << i;
      }
    }
  }
}

TEST(SliceInterpolation, IsAtLeastAsGoodAsLinearInterpolationInNoise) {
  // Independent values have no direction in which they continue. Motion would only pick values that
  // happen to be alike, whose mean has a larger variance than that of two independent ones.
  std::srand(1);
  const auto noise = [](double, double, double) { return std::rand() % 2001 - 1000; };
  const Volume stored = volume_of(noise, 96, 12, 2);
  Volume volume = stored;
  refine_slices(volume, 2, 2);
  const auto deviation = [](const Volume& of) {
    double sum = 0;
    for (const std::int16_t value : of.voxels) sum += std::pow(value, 2);
    return std::sqrt(sum / static_cast<double>(of.voxels.size()));
  };
  EXPECT_LT(deviation(volume), 1.1 * deviation(linear(stored, 2)));
}

TEST(SliceInterpolation, StaysWithinTheRangeOfTheStoredValues) {
  std::srand(2);
  const auto extreme = [](double, double, double) { return std::rand() % 2 ? 32767 : -32768; };
  Volume volume = volume_of(extreme, 48, 6, 5);
  refine_slices(volume, 5, 1);
  const auto [least, most] = std::minmax_element(volume.voxels.begin(), volume.voxels.end());
  EXPECT_GE(*least, -32768);
  EXPECT_LE(*most, 32767);
  EXPECT_EQ(volume.voxels.size(), volume.header.voxel_count());
}

TEST(SliceInterpolation, IsTheSameWithAnyNumberOfThreads) {
  Volume one = volume_of(ball, 96, 32, 3), many = one;
  refine_slices(one, 3, 1);
  refine_slices(many, 3, 5);
  EXPECT_EQ(one.voxels, many.voxels);
}

TEST(SliceInterpolation, HandlesVolumesWithoutContentAndVerySmallOnes) {
  const auto nothing = [](double, double, double) { return 7; };
  for (const std::uint32_t side : {1U, 2U, 5U, 64U}) {
    Volume volume = volume_of(nothing, side, 2, 4);
    refine_slices(volume, 4, 3);
    EXPECT_EQ(volume.voxels, std::vector<std::int16_t>(std::size_t{side} * side * 8, 7)) << side;
  }
}

TEST(SliceMotion, MeasuresTheShiftOfASquare) {
  const auto square = [](double left) {
    SliceImage plane(96, 96);
    for (int y = 20; y < 60; ++y) {
      for (int x = 0; x < 96; ++x) {
        const double inside = std::min(x + 0.5 - left, left + 40 - x - 0.5);
        plane.row(y)[x] = static_cast<float>(std::clamp(inside + 0.5, 0., 1.));
      }
    }
    return plane;
  };
  const Motion motion = estimate_motion(square(20), square(26));
  // On the left edge, half way between its two positions. The window averages the motion with that
  // of places without structure, where it is 0, so the estimate tends to be too small.
  EXPECT_NEAR(motion.x.row(40)[23], 6, 1);
  EXPECT_NEAR(motion.y.row(40)[23], 0, 0.5);
}

}  // namespace
}  // namespace diaphane::volume
