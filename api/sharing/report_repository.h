#pragma once

#include "api/shared/database.h"
#include "api/sharing/reports.h"

namespace diaphane::api {

/// Reports and take-downs of data sets (migrations/0005) and of presets (0008).
class ReportRepository final : public ReportStore {
 public:
  explicit ReportRepository(Database& database) : database_(database) {}

  Result<void> report(const Report& report, const std::string& reporter_id) override;
  Result<std::vector<Report>> open(int limit, const AuditEntry& entry, Time now) override;
  Result<int> count_open() override;
  Result<std::vector<TakeDown>> taken_down(int limit, const AuditEntry& entry, Time now) override;
  Result<void> close(const std::string& report_id, const AuditEntry& entry, Time now) override;
  Result<void> take_down(const std::string& data_set_id, const std::string& reason,
                         const AuditEntry& entry, Time now) override;
  Result<void> restore(const std::string& data_set_id, const AuditEntry& entry, Time now) override;
  Result<void> take_down_preset(const std::string& preset_id, const std::string& reason,
                                const AuditEntry& entry, Time now) override;
  Result<void> restore_preset(const std::string& preset_id, const AuditEntry& entry,
                              Time now) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
