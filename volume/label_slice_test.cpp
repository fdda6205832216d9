#include "volume/label_slice.h"

#include <gtest/gtest.h>

#include <cmath>

#include "volume/second_slice.h"

namespace diaphane::volume {
namespace {

/// A volume in which every voxel has a label of its own, up to 255, and its label as its value.
Volume numbered(std::array<std::uint32_t, 3> size, std::array<double, 9> direction) {
  Volume volume;
  volume.header.size = size;
  volume.header.spacing = {1, 2, 3};
  volume.header.direction = direction;
  volume.label_set.labels.size = size;
  for (std::uint32_t i = 0; i < size[0] * size[1] * size[2]; ++i) {
    volume.voxels.push_back(static_cast<std::int16_t>(i % 256));
    volume.label_set.labels.voxels.push_back(static_cast<std::uint8_t>(i % 256));
  }
  for (std::uint32_t i = 1; i < 256; ++i) volume.label_set.table.push_back({i, "", {}});
  measure(volume);
  return volume;
}

constexpr std::array<double, 9> kStraight{1, 0, 0, 0, 1, 0, 0, 0, 1};
constexpr std::array<double, 9> kTurned{0, -1, 0, 1, 0, 0, 0, 0, 1};

TEST(LabelSlice, LiesExactlyOverTheValuesInEveryPlaneAndOrientation) {
  const double c = std::cos(0.4), s = std::sin(0.4);
  for (const auto& direction : {kStraight, kTurned, {c, -s, 0, s, c, 0, 0, 0, 1}}) {
    const Volume volume = numbered({6, 5, 8}, direction);
    for (const Plane plane : kPlanes) {
      const SliceStack stack = plan_stack(volume.header, plane);
      for (std::uint32_t index = 0; index < stack.slices; ++index) {
        const auto labels = labels_of_slice(volume, stack, index);
        const auto values = slice_of(volume, stack, index).value();
        EXPECT_EQ(std::vector<std::int16_t>(labels.begin(), labels.end()), values)
            << static_cast<int>(plane) << " " << index;
      }
    }
  }
}

TEST(LabelSlice, ShowsThePatientsLeftAtTheRightAndTheFrontAtTheTop) {
  Volume volume = numbered({4, 4, 4}, kStraight);
  std::fill(volume.label_set.labels.voxels.begin(), volume.label_set.labels.voxels.end(), 0);
  // LPS: x to the left, y to the back, z to the head. The voxel at the left, in front and below.
  volume.label_set.labels.voxels[3] = 7;
  const auto at = [&](Plane plane, std::uint32_t index, std::size_t column, std::size_t row) {
    return labels_of_slice(volume, plan_stack(volume.header, plane), index)[column + 4 * row];
  };
  EXPECT_EQ(at(Plane::kAxial, 0, 3, 0), 7);
  EXPECT_EQ(at(Plane::kCoronal, 0, 3, 3), 7);
  EXPECT_EQ(at(Plane::kSagittal, 3, 0, 3), 7);
}

ObliqueSlice axial_plane(double z) {
  ObliqueSlice slice;
  slice.columns = slice.rows = 4;
  slice.first = {-1.5, -1.5, z};
  slice.right = {1, 0, 0};
  slice.down = {0, 1, 0};
  return slice;
}

Volume layered(const std::vector<std::uint8_t>& layers) {
  Volume volume;
  volume.header.size = {4, 4, static_cast<std::uint32_t>(layers.size())};
  volume.voxels.assign(volume.header.voxel_count(), 0);
  volume.label_set.labels.size = volume.header.size;
  for (const std::uint8_t label : layers) {
    volume.label_set.labels.voxels.insert(volume.label_set.labels.voxels.end(), 16, label);
  }
  return volume;
}

TEST(LabelSlice, ASampleHasTheLabelOfItsVoxelAndIsNotInterpolated) {
  const Volume volume = layered({2, 9});
  EXPECT_EQ(labels_of_slice(volume, axial_plane(-0.01)), std::vector<std::uint8_t>(16, 2));
  EXPECT_EQ(labels_of_slice(volume, axial_plane(0.01)), std::vector<std::uint8_t>(16, 9));
  EXPECT_EQ(labels_of_slice(volume, axial_plane(1.01)), std::vector<std::uint8_t>(16, 0));
}

TEST(LabelSlice, APixelOfASlabHasItsMostFrequentLabel) {
  ObliqueSlice slab = axial_plane(0);
  slab.thickness = 5;  // samples at the centres of six layers
  const auto label = [&](const std::vector<std::uint8_t>& layers) {
    return labels_of_slice(layered(layers), slab)[5];
  };
  EXPECT_EQ(label({0, 0, 0, 0, 0, 3}), 3) << "one labelled sample is enough";
  EXPECT_EQ(label({0, 2, 0, 3, 3, 0}), 3);
  EXPECT_EQ(label({0, 3, 0, 2, 3, 2}), 2) << "the first in the table of equally frequent ones";
  EXPECT_EQ(label({0, 0, 0, 0, 0, 0}), 0);
}

TEST(LabelSlice, AClippedSliceHasOnlyTheLabelsOfKeptVoxels) {
  const Volume volume = layered({1, 2, 3, 4});
  ObliqueSlice slab = axial_plane(0);
  slab.thickness = 3;
  const std::array planes{Region::Plane{{0, 0, 1}, {0, 0, 1}}};  // keeps the three lowest layers
  const KeptVoxels kept(volume.header, planes);
  std::vector<std::int16_t> values = sample_clipped(volume, slab, kept);
  values[3] = kBlank;
  const ClippedSlice clipped{kept, values};
  const auto labels = labels_of_slice(volume, slab, &clipped);
  EXPECT_EQ(labels[0], 1);
  EXPECT_EQ(labels[3], 0);
  const SliceStack stack = plan_stack(volume.header, Plane::kAxial);
  const auto hidden = clipped_slice_of(volume, stack, 3, kept).value();
  const ClippedSlice above{kept, hidden};
  EXPECT_EQ(labels_of_slice(volume, stack, 3, &above), std::vector<std::uint8_t>(16, 0));
}

}  // namespace
}  // namespace diaphane::volume
