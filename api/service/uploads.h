#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include "api/service/accounts.h"
#include "api/service/data_set_store.h"
#include "api/service/problem.h"
#include "api/service/tus.h"
#include "common/clock.h"

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
    /// On disk when it returns. kUnavailable: disk full or broken.
    Result<void> write(std::int64_t offset, std::string_view bytes);

   private:
    int fd_;
  };

  /// kConflict when somebody else holds it. Made only with `create`: a later part never brings back
  /// a file that was taken or disposed of.
  Result<Open> open(const std::string& id, bool create);
  /// What is not there is no error.
  Result<void> remove(const std::string& id);
  /// Bytes that can still be written.
  std::int64_t free_bytes() const;

 private:
  std::string path_of(const std::string& id) const { return directory_ + "/" + id + ".tar"; }
  std::string directory_;
};

/// tus 1.0 over the store and the files. Thread-safe.
class Uploads {
 public:
  Uploads(DataSetStore& store, UploadFiles& files, const Clock& clock,
          std::chrono::seconds upload_life);

  /// kNotFound also for somebody else's; kUploadExpired.
  Outcome<Upload> find(const Principal& who, const std::string& id);
  /// The upload after the part; see tus.h for what is refused, and kLocked, kChecksumMismatch.
  Outcome<Upload> append(const Principal& who, const std::string& id, std::string_view offset,
                         std::string_view checksum, std::string_view bytes);
  /// Its data set goes too. kUploadComplete when it is past that.
  Outcome<void> terminate(const Principal& who, const std::string& id);

  /// Called after a file was noted for disposal.
  void on_disposal(std::function<void()> wake) { wake_ = std::move(wake); }

 private:
  Outcome<tus::Part> plan(const Upload& upload, const tus::PartRequest& request) const;

  DataSetStore& store_;
  UploadFiles& files_;
  const Clock& clock_;
  std::chrono::seconds upload_life_;
  std::function<void()> wake_ = [] {};
};

}  // namespace diaphane::api
