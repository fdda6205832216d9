#pragma once

#include <map>
#include <string>
#include <vector>

#include "api/studies/study_store.h"
#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {

/// One study and its participants in memory, which both stores of studies share.
class FakeStudies final : public StudyStore, public ParticipantStore, public Fake {
 public:
  Study study;
  bool open = true;
  std::map<std::string, Participant> people;                   ///< by hash of their key
  std::map<std::string, std::vector<StudyAnswer>> answers_of;  ///< by hash of their key
  std::vector<StudyPicture> stored_pictures;
  SessionIds over;  ///< sessions that expire

  Result<std::variant<Created, KeyReused>> create(const Study& made, int,
                                                  const std::optional<IdempotencyKey>&) override {
    DIAPHANE_TRY(enter("create"));
    study = made;
    return Created{made.id, false};
  }
  Result<std::vector<Study>> of(const std::string&, const std::optional<Cursor>&, int,
                                Time) override {
    DIAPHANE_TRY(enter("of"));
    return std::vector<Study>{study};
  }
  Result<Study> find(const std::string& owner_id, const std::string& id, Time) override {
    DIAPHANE_TRY(enter("find study"));
    if (id != study.id || owner_id != study.owner_id) return none();
    return study;
  }
  Result<SessionIds> replace(const std::string&, const std::string&, int,
                             const std::set<std::string>&, const StudyContent&) override {
    DIAPHANE_TRY(enter("replace"));
    return sessions();
  }
  Result<SessionIds> remove(const std::string&, const std::string&, Time) override {
    DIAPHANE_TRY(enter("remove"));
    return sessions();
  }
  Result<SessionIds> set_state(const std::string&, const std::string&, int, StudyState state,
                               Time) override {
    DIAPHANE_TRY(enter("set_state"));
    study.state = state;
    open = state == StudyState::kOpen;
    return open ? SessionIds{} : sessions();
  }
  Result<void> set_link(const std::string&, const std::string&, const std::string&) override {
    return enter("set_link");
  }
  Result<void> put_picture(const std::string&, const std::string&, const StudyPicture& picture,
                           int) override {
    DIAPHANE_TRY(enter("put_picture"));
    stored_pictures.push_back(picture);
    return {};
  }
  Result<StudyPicture> picture(const std::string&, const std::string& id) override {
    DIAPHANE_TRY(enter("picture"));
    for (const StudyPicture& one : stored_pictures) {
      if (one.id == id) return one;
    }
    return none();
  }
  Result<std::vector<std::string>> pictures(const std::string&) override {
    DIAPHANE_TRY(enter("pictures"));
    std::vector<std::string> ids;
    for (const StudyPicture& one : stored_pictures) ids.push_back(one.id);
    return ids;
  }
  Result<std::vector<Participant>> participants(const std::string&) override {
    DIAPHANE_TRY(enter("participants"));
    return std::vector<Participant>{};
  }
  Result<std::vector<StudyAnswer>> answers(const std::string&) override {
    return std::vector<StudyAnswer>{};
  }
  Result<std::vector<Recorded>> recordings(const std::string&) override {
    return std::vector<Recorded>{};
  }
  Result<void> note_exported(const std::string&, const std::string&, Time) override {
    return enter("note_exported");
  }
  Result<std::string> owner_of(const std::string&) override { return study.owner_id; }
  Result<std::string> comfort() override { return std::string(); }
  Result<void> set_comfort(const std::string&, const std::string&, const std::string&,
                           Time) override {
    return enter("set_comfort");
  }
  Result<std::string> tour(const std::string&) override { return std::string(); }
  Result<void> set_tour(const std::string&, const std::string&, const std::string&, Time) override {
    return enter("set_tour");
  }
  Result<SessionIds> expire(Time) override {
    DIAPHANE_TRY(enter("expire"));
    return over;
  }
  Result<void> forget_session(const std::string& id) override {
    DIAPHANE_TRY(enter("forget_session"));
    std::erase(over, id);
    return {};
  }

  Result<Invitation> invitation(const std::string&, Time) override {
    DIAPHANE_TRY(enter("invitation"));
    return Invitation{study, "", open};
  }
  Result<Participation> join(const std::string&, const Participant& participant,
                             const std::optional<Time>&, Time) override {
    DIAPHANE_TRY(enter("join"));
    if (static_cast<int>(people.size()) >= study.content.places) {
      return fail(ErrorCode::kTooMany, "full");
    }
    people.emplace(participant.key_hash, participant);
    return Participation{people.at(participant.key_hash), study, open};
  }
  Result<Participation> find(const std::string& key_hash, Time) override {
    DIAPHANE_TRY(enter("find"));
    const auto found = people.find(key_hash);
    if (found == people.end()) return none();
    return Participation{found->second, study, open};
  }
  Result<Answered> answered(const std::string&) override {
    DIAPHANE_TRY(enter("answered"));
    return Answered{};
  }
  Result<void> answer(const std::string& key_hash, const StudyAnswer& answer, Time) override {
    DIAPHANE_TRY(enter("answer"));
    if (!people.contains(key_hash)) return none();
    answers_of[key_hash].push_back(answer);
    return {};
  }
  Result<void> add_recording(const std::string&, const std::string&, const std::string&,
                             const RecordingLimits&, Time) override {
    return enter("add_recording");
  }
  Result<void> finish(const std::string&) override { return enter("finish"); }
  Result<std::string> withdraw(const std::string& key_hash) override {
    DIAPHANE_TRY(enter("withdraw"));
    const auto found = people.find(key_hash);
    if (found == people.end()) return std::string();
    const std::string session = found->second.session_id;
    people.erase(found);
    return session;
  }
  Result<void> note_session(const std::string& key_hash, const std::string& earlier,
                            const std::string& session_id, Time) override {
    DIAPHANE_TRY(enter("note_session"));
    std::string& session = people.at(key_hash).session_id;
    if (session != earlier && session != session_id) return fail(ErrorCode::kConflict, "another");
    session = session_id;
    return {};
  }

 private:
  static tl::unexpected<Error> none() { return fail(ErrorCode::kNotFound, "none"); }
  SessionIds sessions() const {
    SessionIds ids;
    for (const auto& [key, one] : people) {
      if (!one.session_id.empty()) ids.push_back(one.session_id);
    }
    return ids;
  }
};

}  // namespace diaphane::api
