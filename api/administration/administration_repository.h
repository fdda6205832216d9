#pragma once

#include "api/administration/administration.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// Accounts as administrators see them, and the audit log (migrations/0004).
class AdministrationRepository final : public AdministrationStore {
 public:
  explicit AdministrationRepository(Database& database) : database_(database) {}

  Result<std::vector<UserRecord>> users(const std::string& part, const std::optional<Cursor>& after,
                                        int limit, Time now) override;
  Result<std::optional<UserRecord>> user(const std::string& id, Time now) override;
  Result<bool> change(const std::string& administrator_id, const std::string& id,
                      const UserChange& change, Time now) override;
  Result<bool> set_administrator(const std::string& email_key, bool granted, Time now) override;
  Result<std::vector<Administrator>> administrators() override;
  Result<void> note(const AuditEntry& entry, Time now) override;
  Result<std::vector<AuditRecord>> audit(const AuditFilter& filter) override;
  Result<IngestQueue> ingest_queue() override;
  Result<std::vector<std::string>> ready_data_sets(const std::string& user_id) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
