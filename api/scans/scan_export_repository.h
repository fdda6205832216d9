#pragma once

#include "api/scans/scan_exports.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// The exports of scans in Postgres (migrations/0027).
class ScanExportRepository final : public ScanExportStore {
 public:
  explicit ScanExportRepository(Database& database) : database_(database) {}
  Result<Request> request(const std::string& user_id, const ScanExport& requested,
                          std::int64_t most_bytes) override;
  Result<std::optional<ScanExport>> find(const std::string& user_id, const std::string& data_set_id,
                                         Time now) override;
  Result<bool> remove(const std::string& user_id, const std::string& data_set_id) override;
  Result<void> expire(Time now) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
