#pragma once

#include "api/privacy/account_deletion.h"
#include "api/privacy/exports.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// Exports and deletes all data about a user. The tables are found by their foreign keys, so that a
/// new table is included in exports and deletions automatically.
class PrivacyRepository final : public ExportStore, public AccountDeletionStore {
 public:
  explicit PrivacyRepository(Database& database) : database_(database) {}

  Result<bool> request(const std::string& user_id, const Export& requested,
                       Time not_since) override;
  Result<std::optional<Export>> find(const std::string& user_id, Time now) override;
  Result<bool> remove(const std::string& user_id, Time now) override;
  Result<std::optional<Job>> claim(Time now, std::chrono::seconds lease) override;
  Result<std::vector<ExportSection>> sections(const std::string& user_id) override;
  Result<std::vector<std::string>> volumes(const std::string& user_id) override;
  Result<std::vector<Picture>> pictures(const std::string& user_id) override;
  Result<std::vector<std::string>> environments(const std::string& user_id) override;
  Result<void> note_download(const std::string& user_id, const Client& client, Time now) override;
  Result<bool> finish(const std::string& id, std::int64_t bytes) override;
  Result<Sizes> sizes(const std::string& user_id) override;
  Result<void> wait(const std::string& id, Time not_before) override;
  Result<void> expire(Time now) override;
  Result<std::vector<std::string>> ids() override;

  Result<std::vector<std::string>> remove_account(const std::string& user_id,
                                                  const std::string& email,
                                                  const std::vector<std::string>& attempt_keys,
                                                  const Mail& notification, Time now) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
