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

/// Implements tus 1.0 (tus.h) with the store and the files. Thread-safe.
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
  /// Writes a part and returns the updated upload. For errors, see tus.h; also returns kLocked,
  /// kChecksumMismatch or kStorageFull. An error discards the part, and the offset does not change.
  Outcome<Upload> append(const Principal& who, const std::string& id, std::string_view offset,
                         std::string_view checksum, std::string_view bytes);
  /// Deletes an upload and, unless it is one of labels, its data set. Returns kUploadComplete.
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
