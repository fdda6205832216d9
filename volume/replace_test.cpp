#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "volume/hash.h"
#include "volume/store.h"
#include "volume/volume.h"

namespace diaphane::volume {
namespace {

namespace fs = std::filesystem;

class Replace : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "diaphane-replace-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    store_ = pattern;
    old_ = filled(7);
    new_ = filled(9);
    ASSERT_TRUE(write(old_, place()).has_value());
  }
  void TearDown() override { fs::remove_all(store_); }
  static Volume filled(std::int16_t value) {
    Volume volume;
    volume.header.size = {4, 3, 2};
    volume.voxels.assign(24, value);
    measure(volume);
    return volume;
  }
  std::string place() const { return (store_ / "a").string(); }
  std::size_t entries() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(store_), fs::directory_iterator()));
  }
  std::int16_t stored() const { return read(place(), content_hash("", 0).has_value())->voxels[0]; }
  fs::path store_;
  Volume old_, new_;
};

TEST_F(Replace, ReplacesVolumeAndErasesTheOldOne) {
  const int held = open((place() + "/voxels.i16").c_str(), O_RDONLY);
  std::string hash_told;
  ASSERT_TRUE(replace(new_, place(), [&]() -> Result<void> {
                hash_told = new_.header.content_hash;
                EXPECT_EQ(stored(), 7);
                return {};
              }).has_value());
  EXPECT_EQ(stored(), 9);
  EXPECT_EQ(entries(), 1U);
  EXPECT_EQ(hash_told, read_header(place())->content_hash);
  char byte = 0;
  EXPECT_EQ(pread(held, &byte, 1, 0), 0) << "who had the old file open reads its end at once";
  close(held);
}

TEST_F(Replace, RefusalBeforeTheExchangeChangesNothing) {
  const auto done =
      replace(new_, place(), []() -> Result<void> { return fail(ErrorCode::kConflict, "no"); });
  ASSERT_FALSE(done.has_value());
  EXPECT_EQ(done.error().code, ErrorCode::kConflict);
  EXPECT_EQ(stored(), 7);
  EXPECT_EQ(entries(), 1U);
}

TEST_F(Replace, DoesNotRestoreDeletedVolume) {
  const auto done = replace(new_, place(), [&]() -> Result<void> {
    fs::remove_all(place());
    return {};
  });
  ASSERT_FALSE(done.has_value());
  EXPECT_EQ(done.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(entries(), 0U);
  EXPECT_EQ(replace(new_, place(), []() -> Result<void> { return {}; }).error().code,
            ErrorCode::kNotFound);
}

TEST_F(Replace, SweepRemovesOldVolumeOfKilledWriter) {
  // A writer that was killed after the exchange leaves the old volume under a temporary name.
  fs::rename(place(), store_ / ".tmp-a-0123456789abcdef");
  EXPECT_EQ(sweep_unfinished(store_.string()).value_or(0), 1U);
  EXPECT_EQ(entries(), 0U);
}

}  // namespace
}  // namespace diaphane::volume
