#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "common/result.h"

namespace diaphane::api {

/// The files that uploads become: `<directory>/<id>.tar`. One writer at a time to each, also across
/// processes.
class UploadFiles {
 public:
  explicit UploadFiles(std::string directory) : directory_(std::move(directory)) {}

  /// Held while a part is written and noted.
  class Open {
   public:
    explicit Open(int fd) : fd_(fd) {}
    ~Open();
    Open(Open&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Open(const Open&) = delete;
    Open& operator=(const Open&) = delete;
    /// On disk when it returns. kTooLarge: the disk has no room, kUnavailable: it is broken; in
    /// both cases the file ends at `offset` again and what was written is given back.
    Result<void> write(std::int64_t offset, std::string_view bytes);

   private:
    int fd_;
  };

  /// kConflict when somebody else holds it; kTooLarge: the disk has no room, kUnavailable. Made
  /// only with `create`: a later part never brings back a file that was taken or disposed of.
  Result<Open> open(const std::string& id, bool create);
  /// What is not there is no error.
  Result<void> remove(const std::string& id);
  /// Bytes that can still be written.
  std::int64_t free_bytes() const;

 private:
  std::string path_of(const std::string& id) const { return directory_ + "/" + id + ".tar"; }
  std::string directory_;
};

}  // namespace diaphane::api
