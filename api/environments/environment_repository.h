#pragma once

#include "api/environments/environments.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// The table `environments` (migrations/0021), whose trigger queues deleted files for disposal.
class EnvironmentRepository final : public EnvironmentStore {
 public:
  explicit EnvironmentRepository(Database& database) : database_(database) {}

  Result<std::vector<Environment>> of(const std::string& owner_id) override;
  Result<Environment> find(const std::string& id) override;
  Result<void> add(const Environment& environment, int most) override;
  Result<void> rename(const std::string& owner_id, const std::string& id,
                      const std::string& name) override;
  Result<void> remove(const std::string& owner_id, const std::string& id) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
