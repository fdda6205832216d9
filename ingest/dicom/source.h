#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"

namespace diaphane::dicom {

/// Files that can be visited repeatedly, always in the same order. Their names carry no meaning.
class FileSource {
 public:
  using Bytes = std::span<const std::byte>;
  /// Returns whether to read the file with this index (from 0). Other files are not read.
  using Want = std::function<bool(std::size_t index)>;
  /// Receives the bytes of one file, valid during the call. An error ends the visit and is returned
  /// by it.
  using Take = std::function<Result<void>(std::size_t index, Bytes bytes)>;

  virtual ~FileSource() = default;
  /// Reads the files that `want` selects. Returns the first error of `take`, or an error of the
  /// source itself.
  virtual Result<void> visit(const Want& want, const Take& take) = 0;
};

/// The regular files under a folder and its subfolders, in the order of their names. Links are not
/// followed. An unreadable file counts as empty.
class FolderSource final : public FileSource {
 public:
  /// Lists the files. Returns kNotFound if `path` is not a folder that can be listed.
  static Result<FolderSource> open(const std::string& path, std::uint64_t largest_file);
  Result<void> visit(const Want& want, const Take& take) override;
  std::size_t size() const { return files_.size(); }

 private:
  std::vector<std::string> files_;
  std::uint64_t largest_file_ = 0;
};

}  // namespace diaphane::dicom
