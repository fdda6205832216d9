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
  expect_invalid(with_runs(std::string("\x09\xd8\x04", 3)), "A label is unknown.");
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

TEST(Labels, ListEachFoundPartThatHasVoxels) {
  Volume volume;
  volume.header.size = {4, 2, 1};
  volume.voxels.resize(8);
  volume.labels = encode(Labels{{4, 2, 1}, {0, 1, 8, 5, 5, 2, 3, 7}});
  list_found_labels(volume);
  std::vector<std::uint32_t> numbers;
  for (const LabelEntry& entry : volume.label_set.table) {
    numbers.push_back(entry.number);
    EXPECT_TRUE(entry.name.empty()) << "the page translates it";
  }
  EXPECT_EQ(numbers, (std::vector<std::uint32_t>{0xFFFFFF05, 0xFFFFFF07, 0xFFFFFF08}));
  EXPECT_EQ(volume.label_set.labels.voxels, (std::vector<std::uint8_t>{0, 0, 3, 1, 1, 0, 0, 2}));
  const LabelSet listed = volume.label_set;
  list_found_labels(volume);
  EXPECT_EQ(volume.label_set.table, listed.table) << "each only once";
  EXPECT_EQ(volume.label_set.labels.voxels, listed.labels.voxels);
  EXPECT_EQ(name_of(listed.table[1]), "airways");
  EXPECT_EQ(name_of(LabelEntry{5, "Vein", {}}), "Vein");
  EXPECT_EQ(found_part(0xFFFFFF07)->label, Label::kAirway);
  EXPECT_EQ(found_part(0xFFFFFF01), nullptr) << "the body is not listed";
  EXPECT_EQ(found_part(5), nullptr);

  volume.label_set = {std::vector<LabelEntry>(kMostLabels - 1), {{4, 2, 1}, {1, 2, 0, 0}}};
  volume.label_set.labels.voxels.resize(8);
  list_found_labels(volume);
  EXPECT_EQ(volume.label_set.table.size(), kMostLabels);
  EXPECT_EQ(volume.label_set.labels.voxels, (std::vector<std::uint8_t>{1, 2, 0, 255, 255, 0, 0, 0}))
      << "only the first part has room";
}

TEST(Labels, WidenDensePartsIntoVoxelsWithoutALabel) {
  constexpr std::array<std::uint32_t, 3> kSize{5, 4, 3};
  const auto index = [&](std::size_t x, std::size_t y, std::size_t z) {
    return x + kSize[0] * (y + kSize[1] * z);
  };
  Volume volume;
  volume.header.size = kSize;
  volume.voxels.resize(60);
  Labels found{kSize, std::vector<std::uint8_t>(60, 1)};
  found.voxels[index(1, 1, 1)] = 5;  // bone
  found.voxels[index(2, 1, 1)] = 6;  // lung, which keeps its voxel
  found.voxels[index(4, 3, 0)] = 6;  // and does not grow
  volume.labels = encode(found);
  list_found_labels(volume);
  ASSERT_TRUE(widen_dense_parts(volume));
  for (std::size_t i = 0; i < 60; ++i) {
    const std::size_t x = i % 5, y = i / 5 % 4;
    std::uint8_t expected = x <= 2 && y <= 2 ? 1 : 0;
    if (i == index(2, 1, 1) || i == index(4, 3, 0)) expected = 2;
    EXPECT_EQ(volume.label_set.labels.voxels[i], expected) << i;
  }
  volume.label_set = {{{7, "liver", {}}}, {kSize, std::vector<std::uint8_t>(60)}};
  volume.label_set.labels.voxels[0] = 1;
  const auto marked = volume.label_set.labels.voxels;
  EXPECT_FALSE(widen_dense_parts(volume)) << "what somebody has marked stays";
  EXPECT_EQ(volume.label_set.labels.voxels, marked);
  volume.label_set = {};
  EXPECT_FALSE(widen_dense_parts(volume));
}

TEST(Labels, HideSurroundingsOfFoundPartsOnly) {
  Volume volume;
  volume.header.size = {9, 1, 1};
  volume.header.minimum = -1000;
  volume.voxels.assign(9, 7);
  volume.labels = encode(Labels{{9, 1, 1}, {0, 1, 2, 3, 4, 5, 6, 7, 8}});
  ASSERT_TRUE(hide_surroundings(volume));
  EXPECT_EQ(volume.voxels, (std::vector<std::int16_t>{-1000, 7, -1000, 7, 7, 7, 7, 7, 7}));
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
  EXPECT_TRUE(volume.label_set.empty()) << "a scan without parts needs no labels";
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
