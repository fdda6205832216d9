#pragma once

#include "api/scans/data_set_store.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// Data sets, uploads, disposals and the view log (migrations/0002, 0020).
class DataSetRepository final : public DataSetStore {
 public:
  explicit DataSetRepository(Database& database) : database_(database) {}

  Result<Creation> create(const NewDataSet& data_set, const DataSetLimits& limits,
                          const std::optional<IdempotencyKey>& key, Time now) override;
  Result<std::vector<DataSet>> list(const Viewer& viewer, std::optional<Cursor> after,
                                    int limit) override;
  Result<DataSet> find(const Viewer& viewer, const std::string& id) override;
  Result<void> describe(const std::string& id, const Description& what, Time now) override;
  Result<void> remove(const Owner& owner, const std::string& id, Time now) override;
  Result<Upload> find_upload(const Owner& owner, const std::string& id) override;
  Result<void> advance_upload(const std::string& id, std::int64_t from, std::int64_t to,
                              Time expires_at, Time now) override;
  Result<void> cancel_upload(const Owner& owner, const std::string& id, Time now) override;
  Result<int> expire_uploads(Time now) override;
  Result<void> note_access(const AuditEntry& entry, Time not_since, Time now) override;
  Result<void> note_view(const View& view, const AuditEntry& entry, Time now) override;
  Result<std::vector<ViewEntry>> views(const std::string& id, const ViewQuery& query) override;
  Result<void> expire_views(Time now) override;
  Result<std::vector<Disposal>> disposals(int limit) override;
  Result<void> disposed(const Disposal& disposal) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
