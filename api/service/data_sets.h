#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "api/service/accounts.h"
#include "api/service/data_set_store.h"
#include "api/service/placement.h"
#include "api/service/problem.h"
#include "common/clock.h"

namespace diaphane::api {

/// Announcing, listing and deleting data sets. Thread-safe.
class DataSets {
 public:
  struct Options {
    std::int64_t max_upload_bytes = std::int64_t{8} << 30;
    std::chrono::seconds upload_life = std::chrono::hours(24);  ///< since the last part
    /// Kept free beside what is announced, for the volume that is built of it and for the database.
    std::int64_t reserve_bytes = std::int64_t{1} << 30;
    DataSetLimits limits{50, 2000};  ///< of one account
  };
  struct Announcement {
    std::string title;
    std::int64_t bytes = 0;
    std::string idempotency_key;  ///< empty: none
  };
  struct Page {
    std::vector<DataSet> items;
    std::optional<Cursor> next;
  };

  /// `free_bytes` says how much room the upload directory has.
  DataSets(DataSetStore& store, Placement& placement, const Clock& clock, Options options,
           std::function<std::int64_t()> free_bytes);

  /// kOverQuota, kTooMany, kTooManyDataSets, kUploadTooLarge, kIdempotencyKeyReused, kStorageFull.
  Outcome<DataSet> announce(const Principal& who, const Announcement& announcement);
  Outcome<Page> list(const Principal& who, std::optional<Cursor> after, int limit);
  /// The one gate of every route: the data set, if this person may do that with it. kNotFound when
  /// he may not even know of it, kForbidden when he may, but not this.
  Outcome<DataSet> authorise(const Principal& who, const std::string& id, Action action);
  Outcome<DataSet> find(const Principal& who, const std::string& id);
  /// To be looked at. kNotReady unless it is built.
  Outcome<DataSet> find_ready(const Principal& who, const std::string& id);
  Outcome<DataSet> describe(const Principal& who, const std::string& id, const Description& what);
  Outcome<void> remove(const Principal& who, const std::string& id);

  const Options& options() const { return options_; }
  /// Called after files were noted for disposal.
  void on_disposal(std::function<void()> wake) { wake_ = std::move(wake); }

 private:
  DataSetStore& store_;
  Placement& placement_;
  const Clock& clock_;
  Options options_;
  std::function<std::int64_t()> free_bytes_;
  std::function<void()> wake_ = [] {};
};

}  // namespace diaphane::api
