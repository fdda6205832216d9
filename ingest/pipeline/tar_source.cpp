#include "ingest/pipeline/tar_source.h"

#include <archive.h>
#include <archive_entry.h>
#include <unistd.h>

#include <algorithm>
#include <memory>

namespace diaphane::ingest {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 18;
constexpr std::uint64_t kBeginning = 4096;

tl::unexpected<Error> broken() {
  return fail(ErrorCode::kInvalid, "the upload is broken or cut off");
}

}  // namespace

Result<void> TarSource::visit(const Want& want, const Take& take) {
  if (lseek(fd_, 0, SEEK_SET) != 0)
    return fail(ErrorCode::kUnavailable, "the upload cannot be read");
  const std::unique_ptr<archive, int (*)(archive*)> in(archive_read_new(), archive_read_free);
  archive_read_support_format_tar(in.get());  // and no filter: nothing is unpacked here
  if (archive_read_open_fd(in.get(), fd_, kBlock) != ARCHIVE_OK) return broken();
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
    if (size < 0) return broken();
    const auto whole = static_cast<std::uint64_t>(size);
    bytes.resize(whole > largest_file_ ? kBeginning : whole);
    if (archive_read_data(in.get(), bytes.data(), bytes.size()) !=
        static_cast<la_ssize_t>(bytes.size())) {
      return broken();
    }
    if (auto ok = take(index, bytes); !ok) return ok;
  }
}

}  // namespace diaphane::ingest
