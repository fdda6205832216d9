#pragma once

#include "api/pacs/archives.h"
#include "api/shared/database.h"

namespace diaphane::api {

class ArchiveRepository final : public ArchiveStore {
 public:
  explicit ArchiveRepository(Database& database) : database_(database) {}
  Result<void> note(const AuditEntry& entry, Time now) override;
  Result<void> begin_fetch(const std::string& user_id, const std::string& token_hash, Time now,
                           Time expires_at, const AuditEntry& entry) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
