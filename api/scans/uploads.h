#pragma once

#include <string>
#include <string_view>

#include "api/accounts/accounts.h"
#include "api/scans/data_set_store.h"
#include "api/scans/tus.h"
#include "api/scans/upload_files.h"
#include "api/shared/problem.h"
#include "api/shared/signals.h"
#include "common/clock.h"

namespace diaphane::api {

/// tus 1.0 on top of the store and the files. Thread-safe.
class Uploads {
 public:
  /// Uploads leave `reserve_bytes` of the disk free, because the database uses the same disk.
  Uploads(DataSetStore& store, UploadFiles& files, const Clock& clock, const Signals& signals,
          std::chrono::seconds upload_life, std::int64_t reserve_bytes);

  /// Returns kNotFound, also for another user's upload, or kUploadExpired.
  Outcome<Upload> find(const Principal& who, const std::string& id);
  /// Checks whether a part of this size would be accepted now. Returns the errors that `append`
  /// returns before it reads the bytes.
  Outcome<void> check_part(const Principal& who, const std::string& id, std::string_view offset,
                           std::string_view checksum, std::int64_t bytes);
  /// Returns the upload after the part. For errors, see tus.h. Also returns kLocked,
  /// kChecksumMismatch or kStorageFull. Then nothing of the part is kept, and the offset is
  /// unchanged.
  Outcome<Upload> append(const Principal& who, const std::string& id, std::string_view offset,
                         std::string_view checksum, std::string_view bytes);
  /// Also deletes its data set. Returns kUploadComplete if all data has arrived.
  Outcome<void> terminate(const Principal& who, const std::string& id);

 private:
  Outcome<tus::Part> plan(const Upload& upload, const tus::PartRequest& request) const;

  DataSetStore& store_;
  UploadFiles& files_;
  const Clock& clock_;
  const Signals& signals_;
  std::chrono::seconds upload_life_;
  std::int64_t reserve_bytes_;
};

}  // namespace diaphane::api
