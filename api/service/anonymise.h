#pragma once

#include <functional>
#include <optional>
#include <string>

#include "api/service/data_sets.h"
#include "api/service/placement.h"
#include "api/service/thumbnails.h"
#include "common/clock.h"

namespace diaphane::api {

/// What is known of a data set for its owner's decision.
struct CutFacts {
  std::string head;     ///< JSON of what ingestd found (ingest/head); empty: not looked for yet
  std::string problem;  ///< why the last cut was not made; empty: it was, or there was none
};

/// An order to cut, for ingestd to carry out.
struct CutOrder {
  std::string data_set_id;
  std::string region;       ///< JSON, volume/region.h
  std::string volume_hash;  ///< of the volume that the owner saw
  std::string asked_by;     ///< user id
};

class CutStore {
 public:
  virtual ~CutStore() = default;
  /// kNotFound.
  virtual Result<CutFacts> facts(const std::string& data_set_id) = 0;
  /// The data set is queued, the order in ingestd's queue and in the audit log: one transaction.
  /// kConflict when the data set is not ready (any more), or gone.
  virtual Result<void> order(const CutOrder& order, Time now) = 0;
};

/// Anonymising: everything outside of a region goes, for good. Thread-safe.
class Anonymise {
 public:
  struct View {
    DataSet data_set;
    CutFacts facts;
    std::string volume_hash;  ///< of the volume as it is now; empty unless ready
  };

  /// `stored_hash` says the content hash of a stored volume; empty when there is none.
  Anonymise(DataSets& data_sets, CutStore& store, Thumbnails& thumbnails, Placement& placement,
            const Clock& clock, std::function<std::string(const std::string& id)> stored_hash)
      : data_sets_(data_sets),
        store_(store),
        thumbnails_(thumbnails),
        placement_(placement),
        clock_(clock),
        stored_hash_(std::move(stored_hash)) {}

  Outcome<View> look(const Principal& who, const std::string& id);
  /// From here on nobody can open the data set until it is cut; those who look at it are sent away.
  /// kNotReady; kPrecondition when the volume is not the one of `volume_hash`.
  Outcome<View> cut(const Principal& who, const std::string& id, const std::string& region,
                    const std::string& volume_hash);
  /// Called after files were noted for disposal.
  void on_disposal(std::function<void()> wake) { wake_ = std::move(wake); }

 private:
  DataSets& data_sets_;
  CutStore& store_;
  Thumbnails& thumbnails_;
  Placement& placement_;
  const Clock& clock_;
  const std::function<std::string(const std::string& id)> stored_hash_;
  std::function<void()> wake_ = [] {};
};

}  // namespace diaphane::api
