#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "api/accounts/accounts.h"
#include "api/scans/data_set_store.h"
#include "api/shared/placement.h"
#include "api/shared/problem.h"
#include "api/shared/signals.h"
#include "common/clock.h"

namespace diaphane::api {

/// Returns how a signed-in user reaches a data set that they may view.
ViewRoute route_of(const Principal& who, const DataSet& data_set);

/// Manages data sets and checks the permissions on them. Thread-safe.
class DataSets {
 public:
  struct Options {
    std::int64_t max_upload_bytes = std::int64_t{8} << 30;
    std::chrono::seconds upload_life = std::chrono::hours(24);  ///< time since the last part
    /// Disk space that must remain free after an announced upload, for the volumes that are built
    /// from uploads and for the database.
    std::int64_t reserve_bytes = std::int64_t{1} << 30;
    DataSetLimits limits{50, 2000};  ///< per account
  };
  struct Announcement {
    std::string title;
    std::int64_t bytes = 0;
    std::string idempotency_key;  ///< empty means none
  };
  struct Page {
    std::vector<DataSet> items;
    std::optional<Cursor> next;
  };

  /// `free_bytes` returns the free space of the upload directory.
  DataSets(DataSetStore& store, Placement& placement, const Clock& clock, const Signals& signals,
           Options options, std::function<std::int64_t()> free_bytes);

  /// Creates a data set and its upload. Returns kOverQuota, kTooMany, kTooManyDataSets,
  /// kUploadTooLarge, kIdempotencyKeyReused or kStorageFull.
  Outcome<DataSet> announce(const Principal& who, const Announcement& announcement);
  Outcome<Page> list(const Principal& who, std::optional<Cursor> after, int limit);
  /// Checks a permission, as every route does. Returns the data set if the user may perform the
  /// action, kNotFound if they must not know of it, or kForbidden if only this action is not
  /// allowed.
  Outcome<DataSet> authorise(const Principal& who, const std::string& id, Action action);
  Outcome<DataSet> find(const Principal& who, const std::string& id);
  /// Finds a data set to view. Returns kNotReady if it is not ready.
  Outcome<DataSet> find_ready(const Principal& who, const std::string& id);
  Outcome<DataSet> describe(const Principal& who, const std::string& id, const Description& what);
  Outcome<void> remove(const Principal& who, const std::string& id);

  /// Records a view in the owner's log (view_log.h) and, at most once per hour, in the audit log.
  Outcome<void> note_view(const std::string& id, const View& view);
  /// Records in the audit log, at most once per hour, that someone other than the owner got a
  /// thumbnail of a data set that is not public.
  Outcome<void> note_picture(const Principal& who, const DataSet& data_set);
  /// The same for a visitor with a link.
  Outcome<void> note_linked_picture(const DataSet& data_set, const std::string& link_id);
  /// Records in the audit log, at most once per hour and format, that the owner downloaded an
  /// export of a data set.
  Outcome<void> note_export_downloaded(const Principal& who, const std::string& id,
                                       const std::string& format);
  /// Lists who viewed the data set, latest first.
  Outcome<ViewPage> views(const Principal& who, const std::string& id, ViewQuery query);
  /// Records in the audit log that the owner created or ended the links to a live session.
  Outcome<void> note_live_links(const Principal& who, const std::string& id,
                                const std::string& action, std::vector<AuditDetail> details = {});

  const Options& options() const { return options_; }

 private:
  /// Writes to the audit log, at most once per hour for the same entry.
  Outcome<void> note_access(const AuditEntry& entry);

  DataSetStore& store_;
  Placement& placement_;
  const Clock& clock_;
  const Signals& signals_;
  Options options_;
  std::function<std::int64_t()> free_bytes_;
};

}  // namespace diaphane::api
