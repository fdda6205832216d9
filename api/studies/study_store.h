#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "api/shared/cursor.h"
#include "api/shared/idempotency.h"
#include "api/studies/study.h"
#include "common/result.h"

namespace diaphane::api {

/// Stores studies for their researchers. Every function returns kUnavailable if the database is
/// unavailable. Each is one transaction, which includes its entry in the audit log. kNotFound also
/// means another researcher's study.
class StudyStore {
 public:
  /// The sessions of participants, which the caller must end.
  using SessionIds = std::vector<std::string>;

  virtual ~StudyStore() = default;
  /// Returns kTooMany if the researcher already has `most`.
  virtual Result<std::variant<Created, KeyReused>> create(
      const Study& study, int most, const std::optional<IdempotencyKey>& key) = 0;
  virtual Result<std::vector<Study>> of(const std::string& owner_id,
                                        const std::optional<Cursor>& after, int limit,
                                        Time now) = 0;
  virtual Result<Study> find(const std::string& owner_id, const std::string& id, Time now) = 0;
  /// Returns kConflict if somebody has joined, with the field "version" if it is not `version`.
  /// Deletes previews, and pictures that are not in `pictures`.
  virtual Result<SessionIds> replace(const std::string& owner_id, const std::string& id,
                                     int version, const std::set<std::string>& pictures,
                                     const StudyContent& content) = 0;
  virtual Result<SessionIds> remove(const std::string& owner_id, const std::string& id,
                                    Time now) = 0;
  /// Opens or closes the study. Returns kConflict if a study to be opened no longer has `version`
  /// or a draft is to be closed, and kNotFound if the owner lost the role.
  virtual Result<SessionIds> set_state(const std::string& owner_id, const std::string& id,
                                       int version, StudyState state, Time now) = 0;
  virtual Result<void> set_link(const std::string& owner_id, const std::string& id,
                                const std::string& token_hash) = 0;
  /// Returns kTooMany if the study already has `most` others, or kConflict if somebody has joined.
  virtual Result<void> put_picture(const std::string& owner_id, const std::string& id,
                                   const StudyPicture& picture, int most) = 0;
  virtual Result<StudyPicture> picture(const std::string& study_id,
                                       const std::string& picture_id) = 0;
  virtual Result<std::vector<std::string>> pictures(const std::string& study_id) = 0;

  /// Lists the participants for an export, without previews.
  virtual Result<std::vector<Participant>> participants(const std::string& study_id) = 0;
  virtual Result<std::vector<StudyAnswer>> answers(const std::string& participant_id) = 0;
  struct Recorded {
    std::string step, body;
  };
  virtual Result<std::vector<Recorded>> recordings(const std::string& participant_id) = 0;
  virtual Result<void> note_exported(const std::string& owner_id, const std::string& id,
                                     Time now) = 0;

  /// Returns the owner of a study, for administrators.
  virtual Result<std::string> owner_of(const std::string& id) = 0;
  /// Returns JSON, or an empty string if nothing was adopted.
  virtual Result<std::string> comfort() = 0;
  /// Adopts `comfort`, or undoes the adoption if it is empty.
  virtual Result<void> set_comfort(const std::string& administrator_id, const std::string& study_id,
                                   const std::string& comfort, Time now) = 0;

  /// Returns the tour of a data set as JSON, or an empty string if it has none.
  virtual Result<std::string> tour(const std::string& data_set_id) = 0;
  /// Sets the tour of a data set, or removes it if `tour` is empty.
  virtual Result<void> set_tour(const std::string& user_id, const std::string& data_set_id,
                                const std::string& tour, Time now) = 0;

  /// Closes the studies that have ended, and deletes old previews. Returns the sessions to end,
  /// which include those of participants who are gone.
  virtual Result<SessionIds> expire(Time now) = 0;
  /// Forgets a session that was ended.
  virtual Result<void> forget_session(const std::string& session_id) = 0;
};

/// Limits of what the participants of a study can store together, and each of them.
struct RecordingLimits {
  std::int64_t per_participant = 0, per_study = 0;  ///< bytes
};

/// Stores the participants of studies. The functions return kUnavailable if the database is
/// unavailable, and kNotFound for an unknown token or key.
class ParticipantStore {
 public:
  virtual ~ParticipantStore() = default;
  struct Invitation {
    Study study;
    std::string researcher;  ///< public name, may be empty
    bool open = false;
  };
  virtual Result<Invitation> invitation(const std::string& token_hash, Time now) = 0;
  /// Adds a participant to the study. Returns the existing one for a known key, kConflict if the
  /// key belongs to another study (field "key"), its participant withdrew (field "withdrawn") or
  /// the study is not open, or kTooMany if all places are taken. Checks neither openness nor places
  /// for a preview, and deletes the oldest preview if there are kMostPreviews.
  virtual Result<Participation> join(const std::string& study_id, const Participant& participant,
                                     const std::optional<Time>& preview_until, Time now) = 0;
  virtual Result<Participation> find(const std::string& key_hash, Time now) = 0;
  struct Answered {
    std::vector<std::string> steps;  ///< IDs
    std::int64_t sequence = 0;       ///< the highest one
  };
  virtual Result<Answered> answered(const std::string& participant_id) = 0;
  /// Stores the answer unless a later one is stored. Returns kConflict if answers are no longer
  /// accepted.
  virtual Result<void> answer(const std::string& key_hash, const StudyAnswer& answer, Time now) = 0;
  virtual Result<void> add_recording(const std::string& key_hash, const std::string& step,
                                     const std::string& body, const RecordingLimits& limits,
                                     Time now) = 0;
  virtual Result<void> finish(const std::string& key_hash) = 0;
  /// Deletes everything of the participant and counts a withdrawal. Returns the session to end, or
  /// an empty string.
  virtual Result<std::string> withdraw(const std::string& key_hash) = 0;
  /// Replaces the session `earlier`. Returns kConflict if the participant has another one by now.
  virtual Result<void> note_session(const std::string& key_hash, const std::string& earlier,
                                    const std::string& session_id, Time expires_at) = 0;
};

}  // namespace diaphane::api
