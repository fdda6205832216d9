#pragma once

#include <functional>
#include <optional>
#include <string>

#include "api/scans/data_sets.h"
#include "api/scans/thumbnails.h"
#include "api/shared/placement.h"
#include "api/shared/signals.h"
#include "common/clock.h"

namespace diaphane::api {

/// What the owner needs to know about a data set before anonymising it.
struct CutFacts {
  /// JSON result of the head detection (ingest/head); empty if it has not run yet.
  std::string head;
  std::string problem;  ///< why the last run failed; empty if it succeeded or there was none
};

/// An anonymisation job for ingestd.
struct CutOrder {
  std::string data_set_id;
  std::string region;       ///< region to keep, as JSON (volume/region.h)
  std::string volume_hash;  ///< hash of the volume that the owner reviewed
  std::string asked_by;     ///< ID of the requesting user
};

/// Stores anonymisation jobs. Every function returns kUnavailable without the database.
class CutStore {
 public:
  virtual ~CutStore() = default;
  /// Returns kNotFound if the data set does not exist.
  virtual Result<CutFacts> facts(const std::string& data_set_id) = 0;
  /// In one transaction, queues the data set and the job for ingestd and writes the audit entry.
  /// Returns kConflict if the data set is not ready or no longer exists.
  virtual Result<void> order(const CutOrder& order, Time now) = 0;
};

/// Permanently removes everything outside a region of a scan. Thread-safe.
class Anonymise {
 public:
  struct View {
    DataSet data_set;
    CutFacts facts;
    std::string volume_hash;  ///< hash of the current volume; empty unless it is ready
  };

  /// `stored_hash` returns the content hash of a stored volume, or an empty string if there is
  /// none.
  Anonymise(DataSets& data_sets, CutStore& store, Thumbnails& thumbnails, Placement& placement,
            const Clock& clock, const Signals& signals,
            std::function<std::string(const std::string& id)> stored_hash)
      : data_sets_(data_sets),
        store_(store),
        thumbnails_(thumbnails),
        placement_(placement),
        clock_(clock),
        signals_(signals),
        stored_hash_(std::move(stored_hash)) {}

  Outcome<View> get(const Principal& who, const std::string& id);
  /// Blocks the data set until it is anonymised and disconnects its viewers. Returns kNotReady, or
  /// kPrecondition if `volume_hash` does not match the volume.
  Outcome<View> cut(const Principal& who, const std::string& id, const std::string& region,
                    const std::string& volume_hash);

 private:
  DataSets& data_sets_;
  CutStore& store_;
  Thumbnails& thumbnails_;
  Placement& placement_;
  const Clock& clock_;
  const Signals& signals_;
  const std::function<std::string(const std::string& id)> stored_hash_;
};

}  // namespace diaphane::api
