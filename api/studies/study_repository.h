#pragma once

#include "api/shared/database.h"
#include "api/studies/study_store.h"

namespace diaphane::api {

class StudyRepository final : public StudyStore {
 public:
  explicit StudyRepository(Database& database) : database_(database) {}

  Result<std::variant<Created, KeyReused>> create(
      const Study& study, int most, const std::optional<IdempotencyKey>& key) override;
  Result<std::vector<Study>> of(const std::string& owner_id, const std::optional<Cursor>& after,
                                int limit, Time now) override;
  Result<Study> find(const std::string& owner_id, const std::string& id, Time now) override;
  Result<SessionIds> replace(const std::string& owner_id, const std::string& id, int version,
                             const std::set<std::string>& pictures,
                             const StudyContent& content) override;
  Result<SessionIds> remove(const std::string& owner_id, const std::string& id, Time now) override;
  Result<SessionIds> set_state(const std::string& owner_id, const std::string& id, int version,
                               StudyState state, Time now) override;
  Result<void> set_link(const std::string& owner_id, const std::string& id,
                        const std::string& token_hash) override;
  Result<void> put_picture(const std::string& owner_id, const std::string& id,
                           const StudyPicture& picture, int most) override;
  Result<StudyPicture> picture(const std::string& study_id, const std::string& picture_id) override;
  Result<std::vector<std::string>> pictures(const std::string& study_id) override;
  Result<std::vector<Participant>> participants(const std::string& study_id) override;
  Result<std::vector<StudyAnswer>> answers(const std::string& participant_id) override;
  Result<std::vector<Recorded>> recordings(const std::string& participant_id) override;
  Result<void> note_exported(const std::string& owner_id, const std::string& id, Time now) override;
  Result<std::string> owner_of(const std::string& id) override;
  Result<std::string> comfort() override;
  Result<void> set_comfort(const std::string& administrator_id, const std::string& study_id,
                           const std::string& comfort, Time now) override;
  Result<std::string> tour(const std::string& data_set_id) override;
  Result<void> set_tour(const std::string& user_id, const std::string& data_set_id,
                        const std::string& tour, Time now) override;
  Result<SessionIds> expire(Time now) override;
  Result<void> forget_session(const std::string& session_id) override;

 private:
  Database& database_;
};

class ParticipantRepository final : public ParticipantStore {
 public:
  explicit ParticipantRepository(Database& database) : database_(database) {}

  Result<Invitation> invitation(const std::string& token_hash, Time now) override;
  Result<Participation> join(const std::string& study_id, const Participant& participant,
                             const std::optional<Time>& preview_until, Time now) override;
  Result<Participation> find(const std::string& key_hash, Time now) override;
  Result<Answered> answered(const std::string& participant_id) override;
  Result<void> answer(const std::string& key_hash, const StudyAnswer& answer, Time now) override;
  Result<void> add_recording(const std::string& key_hash, const std::string& step,
                             const std::string& body, const RecordingLimits& limits,
                             Time now) override;
  Result<void> finish(const std::string& key_hash) override;
  Result<std::string> withdraw(const std::string& key_hash) override;
  Result<void> note_session(const std::string& key_hash, const std::string& earlier,
                            const std::string& session_id, Time expires_at) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
