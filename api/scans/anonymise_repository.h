#pragma once

#include "api/scans/anonymise.h"
#include "api/shared/database.h"

namespace diaphane::api {

class CutRepository final : public CutStore {
 public:
  explicit CutRepository(Database& database) : database_(database) {}
  Result<CutFacts> facts(const std::string& data_set_id) override;
  Result<void> order(const CutOrder& order, Time now) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
