#pragma once

#include <functional>
#include <string>
#include <variant>

#include "api/scans/data_sets.h"

namespace diaphane::api {

struct NewLabels {
  std::string upload_id;
  std::string data_set_id;
  Owner owner;
  std::int64_t bytes = 0;
  Time expires_at;
};

/// Stores the labels of scans. Every function returns kUnavailable if the database is unavailable.
class LabelStore {
 public:
  virtual ~LabelStore() = default;
  struct Begun {};
  using Beginning = std::variant<Begun, OverQuota>;
  /// Begins an upload of labels and ends one that is in progress. Returns kConflict if the data set
  /// is not ready, or if earlier labels are being placed.
  virtual Result<Beginning> begin(const NewLabels& labels, Time now) = 0;
  /// In one transaction, ends an upload in progress, calls `remove_file`, and records that the scan
  /// has no labels. Returns the error of `remove_file`, or kConflict as begin() does.
  virtual Result<void> remove(const Owner& owner, const std::string& data_set_id,
                              const std::function<Result<void>()>& remove_file, Time now) = 0;
};

/// The labels of scans: structures that someone has marked, voxel by voxel. Thread-safe.
class ScanLabels {
 public:
  /// `remove_file` permanently removes the labels of a stored volume.
  ScanLabels(DataSets& data_sets, LabelStore& store, const Clock& clock, const Signals& signals,
             std::int64_t max_bytes, std::function<Result<void>(const std::string& id)> remove_file)
      : data_sets_(data_sets),
        store_(store),
        clock_(clock),
        signals_(signals),
        max_bytes_(max_bytes),
        remove_file_(std::move(remove_file)) {}

  /// Announces a file of labels, which replaces the scan's current labels. Returns the scan with
  /// the upload, or kNotReady, kConflict, kOverQuota or kUploadTooLarge.
  Outcome<DataSet> announce(const Principal& who, const std::string& id, std::int64_t bytes);
  /// Removes the labels of a scan. Returns kNotReady or kConflict.
  Outcome<void> remove(const Principal& who, const std::string& id);

 private:
  /// Returns the scan if its labels may be changed.
  Outcome<DataSet> find(const Principal& who, const std::string& id);

  DataSets& data_sets_;
  LabelStore& store_;
  const Clock& clock_;
  const Signals& signals_;
  std::int64_t max_bytes_;
  const std::function<Result<void>(const std::string& id)> remove_file_;
};

}  // namespace diaphane::api
