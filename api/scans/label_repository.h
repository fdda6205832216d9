#pragma once

#include "api/scans/scan_labels.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// The labels of scans in Postgres (migrations/0023).
class LabelRepository final : public LabelStore {
 public:
  explicit LabelRepository(Database& database) : database_(database) {}
  Result<Beginning> begin(const NewLabels& labels, Time now) override;
  Result<void> remove(const Owner& owner, const std::string& data_set_id,
                      const std::function<Result<void>()>& remove_file, Time now) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
