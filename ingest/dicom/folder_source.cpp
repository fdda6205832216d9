#include <algorithm>
#include <filesystem>
#include <fstream>

#include "ingest/dicom/source.h"

namespace diaphane::dicom {

namespace fs = std::filesystem;

namespace {
constexpr std::size_t kBeginning = 4096;
}

Result<FolderSource> FolderSource::open(const std::string& path, std::uint64_t largest_file) {
  std::error_code error;
  if (!fs::exists(path, error)) return fail(ErrorCode::kNotFound, "the folder does not exist");
  if (!fs::is_directory(path, error)) return fail(ErrorCode::kNotFound, "this is not a folder");
  FolderSource source;
  source.largest_file_ = largest_file;
  fs::recursive_directory_iterator entry(path, fs::directory_options::skip_permission_denied,
                                         error);
  if (error) return fail(ErrorCode::kNotFound, "cannot open the folder");
  for (const fs::recursive_directory_iterator end; entry != end; entry.increment(error)) {
    if (error) return fail(ErrorCode::kUnavailable, "cannot read the whole folder");
    std::error_code ignored;
    if (entry->symlink_status(ignored).type() == fs::file_type::regular) {
      source.files_.push_back(entry->path().string());
    }
  }
  std::sort(source.files_.begin(), source.files_.end());
  return source;
}

Result<void> FolderSource::visit(const Want& want, const Take& take) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    if (!want(i)) continue;
    std::error_code error;
    const std::uintmax_t size = fs::file_size(files_[i], error);
    bytes.clear();
    // The beginning of a file that is too large for a slice is enough to report it.
    if (!error) bytes.resize(size > largest_file_ ? kBeginning : static_cast<std::size_t>(size));
    std::ifstream in(files_[i], std::ios::binary);
    in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
    if (auto ok = take(i, bytes); !ok) return ok;
  }
  return {};
}

}  // namespace diaphane::dicom
