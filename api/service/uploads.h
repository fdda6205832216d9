#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "api/service/accounts.h"
#include "api/service/data_set_store.h"
#include "api/service/problem.h"
#include "api/service/tus.h"
#include "api/service/upload_files.h"
#include "common/clock.h"

namespace diaphane::api {

/// tus 1.0 over the store and the files. Thread-safe.
class Uploads {
 public:
  /// `reserve_bytes` of the disk stay free of uploads: the database writes there, too.
  Uploads(DataSetStore& store, UploadFiles& files, const Clock& clock,
          std::chrono::seconds upload_life, std::int64_t reserve_bytes);

  /// kNotFound also for somebody else's; kUploadExpired.
  Outcome<Upload> find(const Principal& who, const std::string& id);
  /// Whether a part of so many bytes would be taken now: what `append` refuses of it before it
  /// looks at the bytes.
  Outcome<void> check_part(const Principal& who, const std::string& id, std::string_view offset,
                           std::string_view checksum, std::int64_t bytes);
  /// The upload after the part; see tus.h for what is refused, and kLocked, kChecksumMismatch,
  /// kStorageFull (nothing of the part is left; the upload stands where it stood).
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
  std::int64_t reserve_bytes_;
  std::function<void()> wake_ = [] {};
};

}  // namespace diaphane::api
