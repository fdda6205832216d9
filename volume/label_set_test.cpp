#include "volume/label_set.h"

#include <gtest/gtest.h>

#include <set>

#include "volume/slice_interpolation.h"
#include "volume/volume.h"

namespace diaphane::volume {
namespace {

LabelSet example() {
  LabelSet set;
  set.table = {{3, "Liver", {200, 60, 40}}, {17, "Herzhöhle", {10, 20, 30}}, {2035, "", {1, 2, 3}}};
  set.labels = {{4, 3, 2}, std::vector<std::uint8_t>(24, 0)};
  for (std::size_t i = 5; i < 20; ++i)
    set.labels.voxels[i] = static_cast<std::uint8_t>(1 + i / 5 % 3);
  return set;
}

TEST(LabelSet, SurvivesEncodingAndDecoding) {
  const auto again = decode_label_set(encode(example()), {4, 3, 2});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->table, example().table);
  EXPECT_EQ(again->labels.voxels, example().labels.voxels);
}

TEST(LabelSet, IsRefusedIfTruncatedAnywhere) {
  const std::string bytes = encode(example());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_FALSE(decode_label_set(std::string_view(bytes).substr(0, length), {4, 3, 2})) << length;
  }
  EXPECT_FALSE(decode_label_set(bytes + '\x01', {4, 3, 2}));
}

TEST(LabelSet, IsRefusedIfVoxelsAndTableContradict) {
  LabelSet set = example();
  set.labels.voxels[0] = 4;
  EXPECT_FALSE(decode_label_set(encode(set), {4, 3, 2})) << "a label without an entry";
  set = example();
  set.table[1].number = 3;
  EXPECT_FALSE(decode_label_set(encode(set), {4, 3, 2})) << "a number twice";
  set.table[1].number = 0;
  EXPECT_FALSE(decode_label_set(encode(set), {4, 3, 2})) << "the number of no label";
  EXPECT_FALSE(decode_label_set(encode(example()), {4, 2, 3})) << "another volume";
}

TEST(LabelSet, NamesAreShortValidText) {
  EXPECT_EQ(clean_label_name(" Liver\x01\n "), "Liver");
  EXPECT_EQ(clean_label_name("\xff"), "");
  EXPECT_EQ(clean_label_name(std::string(63, 'a') + "ö"), std::string(63, 'a'));
  EXPECT_EQ(clean_label_name(std::string(62, 'a') + "ö"), std::string(62, 'a') + "ö");
}

TEST(LabelSet, EveryLabelHasItsOwnColour) {
  std::set<std::array<std::uint8_t, 3>> colours;
  for (std::size_t i = 0; i < 64; ++i) colours.insert(label_colour(i));
  EXPECT_GT(colours.size(), 60U);
}

TEST(LabelSet, FollowsThinnerSlices) {
  Volume volume;
  volume.header.size = {4, 3, 2};
  volume.header.spacing = {1, 1, 6};
  volume.header.origin = {10, 20, 30};
  volume.voxels.assign(24, 100);
  volume.label_set = example();
  const auto stored = volume.label_set.labels.voxels;
  refine_slices(volume, 3, 1);
  const Labels& labels = volume.label_set.labels;
  EXPECT_EQ(labels.size, volume.header.size);
  ASSERT_EQ(labels.voxels.size(), 72U);
  for (std::size_t i = 0; i < 72; ++i) {
    EXPECT_EQ(labels.voxels[i], stored[i / 36 * 12 + i % 12]) << i;
  }
  EXPECT_DOUBLE_EQ((*volume.header.origin)[2], 28);  // slices of 2 mm in the box from 27 mm on
}

}  // namespace
}  // namespace diaphane::volume
