#include "api/scans/upload_files.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>

#include "api/shared/secrets.h"
#include "common/ids.h"

namespace diaphane::api {
namespace {

TEST(UploadFiles, AllowsOneWriterAndCreatesFileOnlyForFirstPart) {
  const auto directory = std::filesystem::temp_directory_path() / ("uploads-" + random_hex(8));
  std::filesystem::create_directories(directory);
  UploadFiles files(directory);
  const std::string id = new_id();
  EXPECT_FALSE(files.open(id, false));  // a later part creates no file
  {
    auto first = files.open(id, true);
    ASSERT_TRUE(first);
    const auto second = files.open(id, true);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::kConflict);
    EXPECT_TRUE(first->write(3, "def"));
    EXPECT_TRUE(first->write(0, "abc"));
  }
  EXPECT_EQ(std::filesystem::file_size(directory / (id + ".tar")), 6u);
  EXPECT_TRUE(files.open(id, false));
  EXPECT_TRUE(files.remove(id));
  EXPECT_TRUE(files.remove(id));
  EXPECT_GT(files.free_bytes(), 0);
  std::filesystem::remove_all(directory);
}

TEST(UploadFiles, TruncatesPartialWriteOnFullDisk) {
  const auto directory = std::filesystem::temp_directory_path() / ("uploads-" + random_hex(8));
  std::filesystem::create_directories(directory);
  UploadFiles files(directory);
  const std::string id = new_id();
  // A file size limit simulates a full disk: the part is written up to the limit, and then the
  // write fails.
  struct rlimit before {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto ignored = ::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{1000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  const auto written = [&] {
    auto file = files.open(id, true);
    EXPECT_TRUE(file && file->write(0, std::string(600, 'a')));
    return file->write(600, std::string(600, 'b'));
  }();
  ::setrlimit(RLIMIT_FSIZE, &before);
  ::signal(SIGXFSZ, ignored);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(std::filesystem::file_size(directory / (id + ".tar")), 600u);
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace diaphane::api
