#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "common/result.h"

namespace diaphane::api {

/// The files of uploads, `<directory>/<id>.tar`. Each has only one writer at a time, even across
/// processes.
class UploadFiles {
 public:
  explicit UploadFiles(std::string directory) : directory_(std::move(directory)) {}

  /// A locked file, held open while a part is written and recorded.
  class Open {
   public:
    explicit Open(int fd) : fd_(fd) {}
    ~Open();
    Open(Open&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Open(const Open&) = delete;
    Open& operator=(const Open&) = delete;
    /// Writes the bytes to the disk before it returns. Returns kTooLarge if the disk is full and
    /// kUnavailable if it fails. In both cases, the file is truncated to `offset` again.
    Result<void> write(std::int64_t offset, std::string_view bytes);

   private:
    int fd_;
  };

  /// Opens and locks a file. Returns kConflict if another writer holds it, kTooLarge if the disk is
  /// full, or kUnavailable. Creates the file only with `create`, so that a later part never
  /// recreates a deleted file.
  Result<Open> open(const std::string& id, bool create);
  /// Deletes the file. A missing file is not an error.
  Result<void> remove(const std::string& id);
  /// Returns the free space in bytes.
  std::int64_t free_bytes() const;

 private:
  std::string path_of(const std::string& id) const { return directory_ + "/" + id + ".tar"; }
  std::string directory_;
};

}  // namespace diaphane::api
