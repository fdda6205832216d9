#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"

namespace diaphane::dicom {

/// Some files, to be gone through more than once, always in the same order. Their names mean
/// nothing.
class FileSource {
 public:
  using Bytes = std::span<const std::byte>;
  /// Is the file with this index (from 0) wanted? What is not, is not read.
  using Want = std::function<bool(std::size_t index)>;
  /// The bytes of one file, valid during the call; an error ends the visit with it.
  using Take = std::function<Result<void>(std::size_t index, Bytes bytes)>;

  virtual ~FileSource() = default;
  virtual Result<void> visit(const Want& want, const Take& take) = 0;
};

/// The regular files under a folder and its subfolders, in the order of their names; links are not
/// followed. A file that cannot be read counts as empty.
class FolderSource final : public FileSource {
 public:
  /// kNotFound when `path` is no folder that can be listed.
  static Result<FolderSource> open(const std::string& path, std::uint64_t largest_file);
  Result<void> visit(const Want& want, const Take& take) override;
  std::size_t size() const { return files_.size(); }

 private:
  std::vector<std::string> files_;
  std::uint64_t largest_file_ = 0;
};

}  // namespace diaphane::dicom
