#pragma once

#include "api/presets/recordings.h"
#include "api/shared/database.h"

namespace diaphane::api {

class RecordingRepository final : public RecordingStore {
 public:
  explicit RecordingRepository(Database& database) : database_(database) {}

  Result<bool> consent(const std::string& user_id) override;
  Result<void> set_consent(const std::string& user_id, bool given, Time now) override;
  Result<void> add(const std::string& user_id, const Recording& recording,
                   std::int64_t most_bytes) override;
  Result<std::vector<Recording>> of(const std::string& user_id, Time now) override;
  Result<Recording> find(const std::string& user_id, const std::string& id, Time now) override;
  Result<void> remove(const std::string& user_id, const std::string& id) override;
  Result<void> expire(Time now) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
