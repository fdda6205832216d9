#include "volume/labels.h"

#include <gtest/gtest.h>

namespace diaphane::volume {
namespace {

constexpr std::size_t kHeaderBytes = 12;  // magic with version, and three sizes below 128

Labels example() {
  Labels labels{{5, 4, 30}, std::vector<std::uint8_t>(600, 0)};
  for (std::size_t i = 100; i < 400; ++i) labels.voxels[i] = 1;
  for (std::size_t i = 390; i < 600; i += 7) labels.voxels[i] = static_cast<std::uint8_t>(i % 4);
  return labels;
}

std::string with_runs(const std::string& runs) {
  return encode(Labels{{5, 4, 30}, {}}).substr(0, kHeaderBytes) + runs;
}

void expect_invalid(const std::string& bytes, const std::string& message) {
  const auto labels = decode(bytes, {5, 4, 30});
  ASSERT_FALSE(labels) << message;
  EXPECT_EQ(labels.error().code, ErrorCode::kInvalid);
  EXPECT_EQ(labels.error().message, message);
}

TEST(Labels, SurviveEncodingAndDecoding) {
  const Labels labels = example();
  const auto again = decode(encode(labels), labels.size);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->size, labels.size);
  EXPECT_EQ(again->voxels, labels.voxels);
}

TEST(Labels, SurviveIfThereAreNone) {
  const auto again = decode(encode(Labels{{0, 4, 2}, {}}), {0, 4, 2});
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->voxels.empty());
}

TEST(Labels, TakeFewBytesForLongRuns) {
  const Labels labels{{200, 200, 200}, std::vector<std::uint8_t>(8'000'000, 1)};
  const std::string bytes = encode(labels);
  EXPECT_LT(bytes.size(), 24U);
  EXPECT_EQ(decode(bytes, labels.size)->voxels, labels.voxels);
}

TEST(Labels, AreRefusedIfTruncatedAnywhere) {
  const std::string bytes = encode(example());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_FALSE(decode(std::string_view(bytes).substr(0, length), {5, 4, 30})) << length;
  }
}

TEST(Labels, AreRefusedForAnotherSizeOrVersion) {
  std::string bytes = encode(example());
  EXPECT_FALSE(decode(bytes, {4, 5, 30}));
  bytes[8] = 2;
  expect_invalid(bytes, "These are not labels of this version.");
}

TEST(Labels, AreRefusedIfARunIsTooLong) {
  const std::string wrong = "A run of labels has an invalid length.";
  expect_invalid(with_runs(std::string("\x01\xd9\x04", 3)), wrong);  // 601 voxels
  expect_invalid(with_runs(std::string("\x01\xd8\x04\x01\x01", 5)), wrong);
  expect_invalid(with_runs(std::string("\x01\x00", 2)), wrong);
  expect_invalid(with_runs("\x01\xff\xff\xff\xff\xff\xff\xff\xff\x7f"), wrong);
  EXPECT_TRUE(decode(with_runs(std::string("\x01\xd8\x04", 3)), {5, 4, 30}));
}

TEST(Labels, AreRefusedIfANumberHasTooManyBytes) {
  expect_invalid(with_runs("\x01\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01"),
                 "The labels are cut off.");
}

TEST(Labels, AreRefusedIfALabelIsUnknown) {
  expect_invalid(with_runs(std::string("\x05\xd8\x04", 3)), "A label is unknown.");
}

TEST(Labels, AreRefusedIfTheSizeDoesNotFitInMemory) {
  const std::array<std::uint32_t, 3> size{0xffffffff, 0xffffffff, 0xffffffff};
  EXPECT_FALSE(decode(encode(Labels{size, {}}), size));
  const std::array<std::uint32_t, 3> large{0xffffffff, 0xffffffff, 1};
  EXPECT_FALSE(decode(encode(Labels{large, {}}), large));
}

TEST(Labels, HideEverythingThatShowsNothingOfThePatient) {
  Volume volume;
  volume.header.size = {4, 1, 1};
  volume.header.minimum = -1000;
  volume.voxels = {5, 6, 7, 8};
  EXPECT_FALSE(has_brain(volume));
  ASSERT_TRUE(hide_surroundings(volume)) << "without labels everything counts as body";
  EXPECT_EQ(volume.voxels, (std::vector<std::int16_t>{5, 6, 7, 8}));
  volume.labels = encode(Labels{{4, 1, 1}, {0, 1, 2, 3}});
  ASSERT_TRUE(hide_surroundings(volume));
  EXPECT_EQ(volume.voxels, (std::vector<std::int16_t>{-1000, 6, -1000, 8}));
  volume.labels = encode(Labels{{4, 1, 1}, {4, 0, 2, 4}});
  ASSERT_TRUE(hide_surroundings(volume));
  EXPECT_EQ(volume.voxels, (std::vector<std::int16_t>{-1000, -1000, -1000, 8}));
}

TEST(Labels, ListTheBrainBesideMarkedStructures) {
  Volume volume;
  volume.header.size = {4, 1, 1};
  volume.voxels = {5, 6, 7, 8};
  volume.labels = encode(Labels{{4, 1, 1}, {1, 4, 4, 0}});
  EXPECT_TRUE(has_brain(volume));
  EXPECT_FALSE(has_support(volume));
  list_found_labels(volume);
  ASSERT_EQ(volume.label_set.table.size(), 1U);
  EXPECT_EQ(volume.label_set.table[0].number, kBrainNumber);
  EXPECT_EQ(volume.label_set.labels.voxels, (std::vector<std::uint8_t>{0, 1, 1, 0}));

  volume.label_set = {{{9, "nucleus", {}}}, {{4, 1, 1}, {0, 0, 1, 1}}};
  list_found_labels(volume);
  ASSERT_EQ(volume.label_set.table.size(), 2U);
  EXPECT_EQ(volume.label_set.labels.voxels, (std::vector<std::uint8_t>{0, 2, 1, 1}))
      << "what somebody has marked stays";

  volume.label_set = {std::vector<LabelEntry>(kMostLabels), {{4, 1, 1}, {0, 0, 1, 255}}};
  list_found_labels(volume);
  EXPECT_EQ(volume.label_set.table.size(), kMostLabels);
  volume.label_set = {};
  volume.labels = encode(Labels{{4, 1, 1}, {0, 1, 2, 3}});
  list_found_labels(volume);
  EXPECT_TRUE(volume.label_set.empty()) << "a scan without a brain needs no labels";
}

TEST(Labels, HideNothingIfDamaged) {
  Volume volume;
  volume.header.size = {4, 1, 1};
  volume.voxels = {5, 6, 7, 8};
  volume.labels = encode(Labels{{4, 1, 1}, {0, 1, 2, 3}});
  volume.labels.pop_back();
  EXPECT_FALSE(hide_surroundings(volume));
  EXPECT_FALSE(check_labels(volume.labels, volume.header.size));
  EXPECT_EQ(volume.voxels, (std::vector<std::int16_t>{5, 6, 7, 8}));
}

}  // namespace
}  // namespace diaphane::volume
