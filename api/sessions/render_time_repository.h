#pragma once

#include "api/sessions/render_time.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// The rendering time per account and month (migrations/0004).
class RenderTimeRepository final : public RenderTimeStore {
 public:
  explicit RenderTimeRepository(Database& database) : database_(database) {}

  Result<std::vector<std::string>> add(
      const std::vector<std::pair<std::string, std::int64_t>>& spent, Time now,
      Time ended_if_warned_by) override;
  Result<std::vector<std::string>> warned(Time now, Time from, Time until) override;
  Result<RenderAccount> account(const std::string& user_id, Time now) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
