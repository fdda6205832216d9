#include "ingest/dicom/stack.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace diaphane::dicom {
namespace {

constexpr double kPixel = 0.7;

/// Returns a random rotation, from a random quaternion.
Axes turned(std::mt19937& random) {
  std::normal_distribution<double> normal;
  double q[4];
  double length = 0;
  for (double& v : q) {
    v = normal(random);
    length += v * v;
  }
  for (double& v : q) v /= std::sqrt(length);
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  Axes axes;
  axes.row = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)};
  axes.column = {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)};
  axes.normal = cross(axes.row, axes.column);
  return axes;
}

Vec3 at(const Axes& axes, double x, double y, double z) {
  Vec3 p{};
  for (std::size_t i = 0; i < 3; ++i)
    p[i] = x * axes.row[i] + y * axes.column[i] + z * axes.normal[i];
  return p;
}

std::vector<Vec3> stack_of(const Axes& axes, int n, double spacing) {
  std::vector<Vec3> positions;
  for (int i = 0; i < n; ++i) positions.push_back(at(axes, 31, -17, 55 + i * spacing));
  return positions;
}

TEST(Stack, OrderAndSpacingAreIndependentOfFileOrderAndOrientation) {
  std::mt19937 random(7);
  for (int round = 0; round < 100; ++round) {
    const Axes axes = turned(random);
    std::vector<Vec3> positions = stack_of(axes, 40, 1.25);
    std::vector<std::size_t> shuffle(positions.size());
    for (std::size_t i = 0; i < shuffle.size(); ++i) shuffle[i] = i;
    std::shuffle(shuffle.begin(), shuffle.end(), random);
    std::vector<Vec3> shuffled;
    for (const std::size_t i : shuffle) shuffled.push_back(positions[i]);
    const Stack stack = arrange(shuffled, axes, kPixel);
    ASSERT_TRUE(stack.is_volume) << stack.text;
    EXPECT_NEAR(stack.spacing, 1.25, 1e-9);
    for (std::size_t z = 0; z < stack.order.size(); ++z) EXPECT_EQ(shuffle[stack.order[z]], z);
  }
}

TEST(Stack, ToleratesJitterWithinTwoPercent) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> off(-0.0199 * 2, 0.0199 * 2);
  const Axes axes = turned(random);
  std::vector<Vec3> positions;
  for (int i = 0; i < 30; ++i) {
    const double jitter = i == 0 || i == 29 ? 0 : off(random);
    positions.push_back(at(axes, 0, 0, i * 2.0 + jitter));
  }
  const Stack stack = arrange(positions, axes, kPixel);
  ASSERT_TRUE(stack.is_volume) << stack.text;
  EXPECT_NEAR(stack.spacing, 2, 1e-9);
  EXPECT_GT(stack.jitter, 0.001);
}

TEST(Stack, DoesNotTreatAccumulatingDriftAsJitter) {
  // Each distance is within 2% of the mean, but slices in the middle are a full slice off their
  // place.
  std::mt19937 random(3);
  const Axes axes = turned(random);
  std::vector<Vec3> positions;
  double z = 0;
  for (int i = 0; i < 400; ++i) {
    positions.push_back(at(axes, 0, 0, z));
    z += i < 200 ? 0.985 : 1.015;
  }
  const Stack stack = arrange(positions, axes, kPixel);
  ASSERT_TRUE(stack.is_volume) << stack.text;
  EXPECT_FALSE(stack.sources.empty()) << "resampled, not used unchanged";
  EXPECT_NEAR(stack.spacing * static_cast<double>(stack.sources.size() - 1), z - 1.015, 1e-6);
}

/// Compares where the plan takes each slice of the volume, in mm along the normal from the first
/// slice, with where it must lie.
void expect_every_slice_in_its_place(const Stack& stack, const std::vector<Vec3>& positions,
                                     const Axes& axes) {
  for (std::size_t k = 0; k < stack.sources.size(); ++k) {
    const auto below = static_cast<std::size_t>(stack.sources[k].slice);
    const std::size_t above = std::min(below + 1, stack.order.size() - 1);
    const double share = stack.sources[k].slice - static_cast<double>(below);
    const auto along = [&](std::size_t i) {
      return dot(minus(positions[stack.order[i]], positions[stack.order[0]]), axes.normal);
    };
    const double taken = along(below) * (1 - share) + along(above) * share;
    EXPECT_NEAR(taken, static_cast<double>(k) * stack.spacing, 0.021 * stack.spacing) << k;
  }
}

TEST(Stack, FillsFewSmallGapsFromTheNeighbours) {
  std::mt19937 random(5);
  const Axes axes = turned(random);
  std::vector<Vec3> positions = stack_of(axes, 60, 1.5);
  positions.erase(positions.begin() + 20, positions.begin() + 22);
  positions.erase(positions.begin() + 5);
  const Stack stack = arrange(positions, axes, kPixel);
  ASSERT_TRUE(stack.is_volume) << stack.text;
  EXPECT_EQ(stack.missing, 3u);
  EXPECT_EQ(stack.sources.size(), 60u);
  EXPECT_NEAR(stack.spacing, 1.5, 1e-9);
  expect_every_slice_in_its_place(stack, positions, axes);
}

TEST(Stack, CountsMissingSlices) {
  std::mt19937 random(5);
  const Axes axes = turned(random);
  std::vector<Vec3> positions = stack_of(axes, 40, 1.5);
  positions.erase(positions.begin() + 20, positions.begin() + 23);
  positions.erase(positions.begin() + 5);
  const Stack stack = arrange(positions, axes, kPixel);
  EXPECT_FALSE(stack.is_volume);
  EXPECT_EQ(stack.code, "missing_slices");
  EXPECT_NE(stack.text.find("4 slices are missing"), std::string::npos) << stack.text;
}

TEST(Stack, RefusesGapOfThreeSlices) {
  std::mt19937 random(5);
  const Axes axes = turned(random);
  for (const int hole : {2, 3}) {
    std::vector<Vec3> positions = stack_of(axes, 200, 1);
    positions.erase(positions.begin() + 77, positions.begin() + 77 + hole);
    EXPECT_EQ(arrange(positions, axes, kPixel).is_volume, hole == 2) << hole;
  }
}

TEST(Stack, ResamplesVaryingSpacingToTheFinest) {
  std::mt19937 random(5);
  const Axes axes = turned(random);
  // As in a head scan: fine below and twice as coarse above, without missing slices.
  for (const double coarse : {2.0, 2.5, 7.9}) {
    std::vector<Vec3> positions;
    for (int i = 0; i < 20; ++i) positions.push_back(at(axes, 0, 0, i));
    for (int i = 0; i < 20; ++i) positions.push_back(at(axes, 0, 0, 20 + coarse * i));
    const Stack stack = arrange(positions, axes, kPixel);
    ASSERT_TRUE(stack.is_volume) << stack.text;
    EXPECT_NEAR(stack.spacing, 1, 0.02) << coarse;
    EXPECT_NEAR(stack.varying[1], coarse, 1e-9);
    EXPECT_NEAR(stack.spacing * static_cast<double>(stack.sources.size() - 1), 20 + 19 * coarse,
                1e-9);
    expect_every_slice_in_its_place(stack, positions, axes);
  }
  std::vector<Vec3> positions;
  for (int i = 0; i < 20; ++i) positions.push_back(at(axes, 0, 0, i));
  for (int i = 0; i < 20; ++i) positions.push_back(at(axes, 0, 0, 20 + 8.5 * i));
  EXPECT_EQ(arrange(positions, axes, kPixel).code, "varying_spacing");
}

TEST(Stack, MeasuresGantryTilt) {
  std::mt19937 random(5);
  for (const double degrees : {0.2, 5.0, 18.5, -18.5}) {
    const Axes axes = turned(random);
    std::vector<Vec3> positions;
    const double shift = 2 * std::tan(degrees * M_PI / 180);
    for (int i = 0; i < 30; ++i) positions.push_back(at(axes, 0, i * shift, i * 2));
    const Stack stack = arrange(positions, axes, kPixel);
    ASSERT_TRUE(stack.is_volume) << degrees;
    EXPECT_NEAR(stack.tilt, std::abs(degrees), 1e-6);
    EXPECT_NEAR(stack.spacing, 2, 1e-9);
    ASSERT_EQ(stack.sources.size(), 30u);
    EXPECT_NEAR(stack.sources[29].shift[1], 29 * shift, 1e-9);
    EXPECT_NEAR(stack.sources[29].shift[0], 0, 1e-9);
  }
  const Axes axes = turned(random);
  std::vector<Vec3> positions;
  for (int i = 0; i < 30; ++i)
    positions.push_back(at(axes, 0, i * 2 * std::tan(0.09 * M_PI / 180), i * 2));
  const Stack stack = arrange(positions, axes, kPixel);
  EXPECT_TRUE(stack.is_volume && stack.sources.empty()) << "0.09 degrees is not a tilt";
  positions.clear();
  for (int i = 0; i < 30; ++i) positions.push_back(at(axes, 0, i * 3, i * 2));
  EXPECT_EQ(arrange(positions, axes, kPixel).code, "tilted") << "56 degrees is not a gantry tilt";
}

TEST(Stack, RefusesOneShiftedSlice) {
  std::mt19937 random(5);
  const Axes axes = turned(random);
  std::vector<Vec3> positions = stack_of(axes, 30, 1);
  positions[13] = at(axes, 31 + 5, -17, 55 + 13);
  EXPECT_EQ(arrange(positions, axes, kPixel).code, "shifted_slices");
}

TEST(Stack, ClassifiesRepeatedPositions) {
  std::mt19937 random(5);
  const Axes axes = turned(random);
  std::vector<Vec3> twice = stack_of(axes, 30, 1);
  const std::vector<Vec3> once = twice;
  twice.insert(twice.end(), once.begin(), once.end());
  EXPECT_EQ(arrange(twice, axes, kPixel).code, "repeated_position");
  std::vector<Vec3> some = once;
  some.push_back(once[4]);
  EXPECT_EQ(arrange(some, axes, kPixel).code, "repeated_position");
  EXPECT_EQ(arrange(std::vector<Vec3>(30, once[0]), axes, kPixel).code, "one_position");
}

TEST(Axes, AreRightHanded) {
  std::mt19937 random(13);
  for (int round = 0; round < 50; ++round) {
    Axes given = turned(random);
    if (round % 2 == 1) given.column = minus({0, 0, 0}, given.column);  // rows from below
    Axes axes;
    ASSERT_TRUE(make_axes({given.row[0], given.row[1], given.row[2], given.column[0],
                           given.column[1], given.column[2]},
                          axes));
    EXPECT_NEAR(dot(cross(axes.row, axes.column), axes.normal), 1, 1e-9);
  }
}

TEST(Axes, RefusesInvalidDirections) {
  Axes axes;
  EXPECT_FALSE(make_axes({0, 0, 0, 0, 0, 0}, axes));
  EXPECT_FALSE(make_axes({1, 0, 0, 1, 0, 0}, axes));
  EXPECT_FALSE(make_axes({2, 0, 0, 0, 1, 0}, axes));
  EXPECT_TRUE(make_axes({0.9999, 0.003, 0, -0.003, 0.9999, 0}, axes)) << "rounding is corrected";
  EXPECT_NEAR(dot(axes.row, axes.column), 0, 1e-12);
}

}  // namespace
}  // namespace diaphane::dicom
