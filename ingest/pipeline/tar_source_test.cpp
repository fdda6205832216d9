#include "ingest/pipeline/tar_source.h"

#include <archive.h>
#include <archive_entry.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <string>
#include <vector>

namespace diaphane::ingest {
namespace {

struct Entry {
  std::string name;
  std::string data;
  unsigned type = AE_IFREG;
  std::string link{};
};

/// A tar in memory, as a descriptor.
int tar_of(const std::vector<Entry>& entries, std::size_t cut = 0) {
  std::vector<char> buffer(1 << 20);
  std::size_t used = 0;
  archive* out = archive_write_new();
  archive_write_set_format_pax_restricted(out);
  archive_write_open_memory(out, buffer.data(), buffer.size(), &used);
  for (const Entry& entry : entries) {
    archive_entry* e = archive_entry_new();
    archive_entry_set_pathname(e, entry.name.c_str());
    archive_entry_set_filetype(e, entry.type);
    archive_entry_set_perm(e, 0644);
    archive_entry_set_size(e, static_cast<la_int64_t>(entry.data.size()));
    if (!entry.link.empty()) archive_entry_set_symlink(e, entry.link.c_str());
    archive_write_header(out, e);
    archive_write_data(out, entry.data.data(), entry.data.size());
    archive_entry_free(e);
  }
  archive_write_free(out);
  const int fd = memfd_create("tar", MFD_CLOEXEC);
  const ssize_t written = write(fd, buffer.data(), cut != 0 ? cut : used);
  EXPECT_GT(written, 0);
  return fd;
}

std::vector<std::pair<std::size_t, std::string>> all(TarSource& source) {
  std::vector<std::pair<std::size_t, std::string>> found;
  auto ok = source.visit(
      [](std::size_t) { return true; },
      [&](std::size_t index, dicom::FileSource::Bytes bytes) -> Result<void> {
        found.emplace_back(index,
                           std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
        return {};
      });
  EXPECT_TRUE(ok.has_value());
  return found;
}

TEST(TarSource, VisitsFilesInTheSameOrderEachTime) {
  TarSource source(tar_of({{"a", "one"}, {"b", ""}, {"c", std::string(3000, 'c')}}), 1 << 20);
  const auto first = all(source);
  ASSERT_EQ(first.size(), 3u);
  EXPECT_EQ(first[0].second, "one");
  EXPECT_EQ(first[2].second.size(), 3000u);
  EXPECT_EQ(all(source), first);
}

TEST(TarSource, IgnoresNamesAndReadsOnlyRegularFiles) {
  TarSource source(tar_of({{"../../etc/passwd", "one"},
                           {"link", "", AE_IFLNK, "/etc/passwd"},
                           {"/absolute", "two"},
                           {"folder", "", AE_IFDIR}}),
                   1 << 20);
  const auto found = all(source);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].second, "one");
  EXPECT_EQ(found[1].second, "two");
}

TEST(TarSource, ReadsOnlyTheBeginningOfOversizedFiles) {
  TarSource source(tar_of({{"a", std::string(100000, 'a')}, {"b", "two"}}), 50000);
  const auto found = all(source);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].second.size(), 4096u);
  EXPECT_EQ(found[1].second, "two");
}

TEST(TarSource, RefusesTruncatedArchive) {
  TarSource source(tar_of({{"a", std::string(5000, 'a')}, {"b", std::string(5000, 'b')}}, 7000),
                   1 << 20);
  auto done =
      source.visit([](std::size_t) { return true; },
                   [](std::size_t, dicom::FileSource::Bytes) -> Result<void> { return {}; });
  ASSERT_FALSE(done.has_value());
  EXPECT_EQ(done.error().code, ErrorCode::kInvalid);
}

TEST(TarSource, RefusesCompressedArchive) {
  // No filters, so that nobody can send a bomb as .tar.gz.
  const int fd = memfd_create("gz", MFD_CLOEXEC);
  ASSERT_EQ(write(fd, "\x1f\x8b\x08\x00\x00\x00\x00\x00\x00\x03 and more of it", 26), 26);
  TarSource source(fd, 1 << 20);
  EXPECT_FALSE(source
                   .visit([](std::size_t) { return true; },
                          [](std::size_t, dicom::FileSource::Bytes) -> Result<void> { return {}; })
                   .has_value());
}

}  // namespace
}  // namespace diaphane::ingest
