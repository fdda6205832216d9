#pragma once

#include "api/shared/database.h"
#include "api/sharing/sharing_store.h"

namespace diaphane::api {

/// People, links, the gallery and visits (migrations/0005).
class SharingRepository final : public SharingStore {
 public:
  explicit SharingRepository(Database& database) : database_(database) {}

  Result<std::vector<SharedPerson>> people(const std::string& data_set_id) override;
  Result<Shared> share_with(const std::string& data_set_id, const SharedPerson& person, int most,
                            const Mail& mail) override;
  Result<Shared> change_person(const std::string& data_set_id, const std::string& person_id,
                               const PersonChange& change, Time now) override;
  Result<std::string> unshare(const std::string& data_set_id, const std::string& person_id,
                              Time now) override;
  Result<std::vector<DataSetLink>> links(const std::string& data_set_id, Time now) override;
  Result<std::variant<DataSetLink, KeyReused>> make_link(
      const std::string& data_set_id, const DataSetLink& link, const std::string& token_hash,
      int most, const std::string& owner_id, const std::optional<IdempotencyKey>& key) override;
  Result<void> end_link(const std::string& data_set_id, const std::string& link_id,
                        Time now) override;
  Result<Followed> follow(const std::string& token_hash, Time now) override;
  Result<bool> publish(const std::string& data_set_id, const Permissions& allowed,
                       Time now) override;
  Result<void> make_private(const std::string& data_set_id, Time now) override;
  Result<std::vector<DataSet>> gallery(const Viewer& viewer, const GalleryQuery& query) override;
  Result<std::string> public_name(const std::string& user_id) override;
  Result<void> set_public_name(const std::string& user_id, const std::string& name) override;
  Result<Visit> note_visit(const Visit& visit, const VisitLimits& limits, Time now) override;
  Result<Visit> find_visit(const std::string& session_id, Time now) override;
  Result<std::vector<std::string>> expired_visits(Time now) override;
  Result<void> forget_visit(const std::string& session_id) override;
  Result<void> expire_links(Time now) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
