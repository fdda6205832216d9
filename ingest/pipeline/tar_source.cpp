#include "ingest/pipeline/tar_source.h"

#include <archive.h>
#include <archive_entry.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <vector>

namespace diaphane::ingest {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 18;

/// Input of libarchive. Its own reader for descriptors queries the type of the file, which the
/// sandbox does not allow.
struct Input {
  int fd;
  off_t length;
  bool& failed;
  std::vector<char> block = std::vector<char>(kBlock);
};

la_ssize_t read_block(archive* in, void* data, const void** block) {
  Input& input = *static_cast<Input*>(data);
  *block = input.block.data();
  for (;;) {
    const ssize_t got = read(input.fd, input.block.data(), input.block.size());
    if (got >= 0) return got;
    if (errno == EINTR) continue;
    input.failed = true;
    archive_set_error(in, errno, "cannot read the upload");
    return ARCHIVE_FATAL;
  }
}

/// Skips unwanted files without reading them.
la_int64_t skip(archive* /*in*/, void* data, la_int64_t bytes) {
  const Input& input = *static_cast<Input*>(data);
  const off_t at = lseek(input.fd, 0, SEEK_CUR);
  const off_t to = std::min<off_t>(input.length, at + bytes);
  return lseek(input.fd, to, SEEK_SET) == to ? to - at : 0;
}

constexpr std::uint64_t kBeginning = 4096;

tl::unexpected<Error> broken() {
  return fail(ErrorCode::kInvalid, "the upload is damaged or incomplete");
}

}  // namespace

Result<void> TarSource::visit(const Want& want, const Take& take) {
  // Nothing is decompressed here, so no file is longer than the archive.
  const off_t length = lseek(fd_, 0, SEEK_END);
  if (length < 0 || lseek(fd_, 0, SEEK_SET) != 0) {
    failed_ = true;
    return fail(ErrorCode::kUnavailable, "cannot read the upload");
  }
  const std::unique_ptr<archive, int (*)(archive*)> in(archive_read_new(), archive_read_free);
  archive_read_support_format_tar(in.get());  // no filter, because nothing is decompressed
  Input input{fd_, length, failed_};
  if (archive_read_open2(in.get(), &input, nullptr, read_block, skip, nullptr) != ARCHIVE_OK) {
    return broken();
  }
  std::vector<std::byte> bytes;
  archive_entry* entry = nullptr;
  for (std::size_t index = 0;; ++index) {
    const int code = archive_read_next_header(in.get(), &entry);
    if (code == ARCHIVE_EOF) return {};
    if (code != ARCHIVE_OK) return broken();
    if (archive_entry_filetype(entry) != AE_IFREG || archive_entry_hardlink(entry) != nullptr ||
        !want(index)) {
      continue;
    }
    const la_int64_t size = archive_entry_size(entry);
    // A sparse file claims zeros that were never sent.
    if (size < 0 || size > length || archive_entry_sparse_count(entry) > 0) return broken();
    const auto file_bytes = static_cast<std::uint64_t>(size);
    const std::uint64_t read_bytes = file_bytes > largest_file_ ? kBeginning : file_bytes;
    // Frees the old buffer before the new one is allocated.
    if (read_bytes > bytes.capacity()) bytes = {};
    bytes.resize(read_bytes);
    if (archive_read_data(in.get(), bytes.data(), bytes.size()) !=
        static_cast<la_ssize_t>(bytes.size())) {
      return broken();
    }
    if (auto ok = take(index, bytes); !ok) return ok;
  }
}

}  // namespace diaphane::ingest
