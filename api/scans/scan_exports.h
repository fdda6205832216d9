#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "api/scans/data_sets.h"
#include "api/shared/signals.h"
#include "common/clock.h"

namespace diaphane::api {

/// What to export of a scan: all voxels (NIfTI), or the surface of a label or of a threshold.
struct ScanExportOrder {
  std::string format;                 ///< one of kScanExportFormats
  std::optional<std::int64_t> label;  ///< number of the label
  std::optional<std::int64_t> above;  ///< smallest value that the surface encloses
  std::int64_t phase = 0;             ///< phase of the scan, for `above`
};

inline constexpr std::array<std::string_view, 3> kScanExportFormats{"nifti", "stl", "glb"};

/// The export of a scan that a user has requested. A user has at most one.
struct ScanExport {
  std::string id, data_set_id;
  ScanExportOrder order;
  std::string state;  ///< "queued", "ready" or "failed"
  std::int64_t bytes = 0;
  bool waiting = false;                    ///< for disk space or memory, in state "queued"
  std::string problem_code, problem_text;  ///< in state "failed"
  Time created_at, expires_at;
};

/// Every function returns kUnavailable if the database is unavailable.
class ScanExportStore {
 public:
  virtual ~ScanExportStore() = default;
  enum class Request { kMade, kBusy, kFull, kNotReady };
  /// Adds the export and an audit entry, and replaces the user's earlier export. Returns kBusy
  /// while that one is queued, kFull if all exports together would need more than `most_bytes`, and
  /// kNotReady if the scan has changed its state. Then the earlier export stays.
  virtual Result<Request> request(const std::string& user_id, const ScanExport& requested,
                                  std::int64_t most_bytes) = 0;
  /// Returns the user's export of this data set.
  virtual Result<std::optional<ScanExport>> find(const std::string& user_id,
                                                 const std::string& data_set_id, Time now) = 0;
  /// Deletes the user's export of this data set. Returns false if there is none.
  virtual Result<bool> remove(const std::string& user_id, const std::string& data_set_id) = 0;
  virtual Result<void> expire(Time now) = 0;
};

/// Exports of scans as files for other programs, for the owner only: a file contains every value,
/// which no permission to see slices or to save videos includes. ingestd makes them
/// (ingest/pipeline/export_work.h). Thread-safe.
class ScanExports {
 public:
  static constexpr std::chrono::hours kLife{24};

  struct File {
    std::string stored;  ///< name in the export directory
    std::string name;    ///< name for the user, without anything from the scan
    std::string content_type;
  };

  ScanExports(DataSets& data_sets, ScanExportStore& store, const Clock& clock,
              const Signals& signals, std::int64_t most_bytes)
      : data_sets_(data_sets),
        store_(store),
        clock_(clock),
        signals_(signals),
        most_bytes_(most_bytes) {}

  /// Requests an export. Returns kNotReady, kForbidden for anyone but the owner, kTooMany while
  /// another one is being made, or kStorageFull.
  Outcome<ScanExport> request(const Principal& who, const std::string& data_set_id,
                              const ScanExportOrder& order);
  /// Returns the user's export of this scan, or kNotFound.
  Outcome<ScanExport> find(const Principal& who, const std::string& data_set_id);
  Outcome<void> remove(const Principal& who, const std::string& data_set_id);
  /// Records the download and returns the file, or kNotReady, kForbidden or kNotFound.
  Outcome<File> file(const Principal& who, const std::string& data_set_id);
  /// Deletes expired exports.
  void expire();

 private:
  DataSets& data_sets_;
  ScanExportStore& store_;
  const Clock& clock_;
  const Signals& signals_;
  std::int64_t most_bytes_;
};

}  // namespace diaphane::api
