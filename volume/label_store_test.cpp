#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "volume/hash.h"
#include "volume/region.h"
#include "volume/store.h"
#include "volume/volume.h"

namespace diaphane::volume {
namespace {

namespace fs = std::filesystem;

class LabelStore : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!content_hash("", 0)) GTEST_SKIP() << "without libsodium";
    std::string pattern = (fs::temp_directory_path() / "diaphane-labels-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    store_ = pattern;
    Volume volume;
    volume.header.size = {4, 3, 2};
    volume.header.origin = {-20, 35.5, -400};
    volume.header.frame_of_reference = "1.2.3";
    volume.voxels.assign(24, 7);
    measure(volume);
    ASSERT_TRUE(write(volume, place()).has_value());
  }
  void TearDown() override {
    if (!store_.empty()) fs::remove_all(store_);
  }
  std::string place() const { return (store_ / "a").string(); }
  static LabelSet labels(const std::string& name, std::uint32_t size_x = 4) {
    LabelSet set;
    set.table = {{.number = 5, .name = name, .colour = {1, 2, 3}}};
    set.labels.size = {size_x, 3, 2};
    set.labels.voxels.assign(std::size_t{size_x} * 6, 0);
    set.labels.voxels[3] = 1;
    return set;
  }
  fs::path store_;
};

TEST_F(LabelStore, AddsReplacesAndRemovesLabels) {
  const std::string before = *stored_version(place());
  EXPECT_TRUE(read(place(), true)->label_set.empty());
  ASSERT_TRUE(write_label_set(encode(labels("Liver")), place()).has_value());
  const auto first = read(place(), true);
  EXPECT_EQ(first->label_set.table, labels("Liver").table);
  EXPECT_EQ(first->label_set.labels.voxels, labels("Liver").labels.voxels);
  EXPECT_EQ(stored_version(place()), version_of(first->header));
  EXPECT_NE(stored_version(place()), before);
  EXPECT_EQ(stored_hash(place()), before) << "the voxels are the same";

  const int held = open((place() + "/label_set").c_str(), O_RDONLY);
  ASSERT_TRUE(write_label_set(encode(labels("Spleen")), place()).has_value());
  EXPECT_EQ(read(place(), true)->label_set.table.front().name, "Spleen");
  ASSERT_TRUE(remove_label_set(place()).has_value());
  EXPECT_TRUE(read(place(), true)->label_set.empty());
  EXPECT_FALSE(fs::exists(place() + "/label_set"));
  EXPECT_EQ(stored_version(place()), before);
  EXPECT_TRUE(remove_label_set(place()).has_value()) << "they are already removed";
  EXPECT_TRUE(remove_label_set((store_ / "b").string()).has_value()) << "there is no volume";
  close(held);
}

TEST_F(LabelStore, KeepsThePlaceAndNotTheFrameOfReference) {
  const auto header = read_header(place());
  EXPECT_EQ(header->origin, (std::array{-20.0, 35.5, -400.0}));
  EXPECT_EQ(header->frame_of_reference, "") << "the UID would identify the examination";
}

TEST_F(LabelStore, DamagedLabelsAreNotShown) {
  ASSERT_TRUE(write_label_set(encode(labels("Liver")), place()).has_value());
  std::ofstream(place() + "/label_set") << encode(labels("Liver", 5));
  EXPECT_EQ(read(place(), false).error().code, ErrorCode::kInvalid) << "of a larger volume";
  fs::resize_file(place() + "/label_set", 3);
  EXPECT_EQ(read(place(), false).error().code, ErrorCode::kInvalid);
  std::ofstream(place() + "/label_set")
      << std::string(most_label_set_bytes(*read_header(place())) + 1, 'x');
  EXPECT_EQ(read(place(), false).error().code, ErrorCode::kInvalid) << "longer than any";
}

TEST_F(LabelStore, CuttingMovesTheOriginAndDropsTheLabels) {
  ASSERT_TRUE(write_label_set(encode(labels("Liver")), place()).has_value());
  Header header = *read_header(place());
  header.spacing = {1, 2, 3};
  const Header left = after(header, Cut{.low = {1, 1, 0}, .size = {3, 2, 2}});
  EXPECT_EQ(left.origin, (std::array{-19.0, 37.5, -400.0}));
  EXPECT_EQ(left.label_hash, "");
}

TEST_F(LabelStore, ErasingAVolumeErasesItsLabels) {
  ASSERT_TRUE(write_label_set(encode(labels("Liver")), place()).has_value());
  const int held = open((place() + "/label_set").c_str(), O_RDONLY);
  erase(place());
  char byte = 0;
  EXPECT_EQ(pread(held, &byte, 1, 0), 0);
  close(held);
  EXPECT_FALSE(fs::exists(place()));
}

}  // namespace
}  // namespace diaphane::volume
