#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "api/accounts/account_store.h"
#include "api/sessions/render_time.h"
#include "api/shared/secrets.h"
#include "api/studies/studies.h"
#include "common/ids.h"

namespace diaphane::api {

/// What people without an account do in a study. They are known only by a random key that their
/// browser chose. Thread-safe.
class Participations {
 public:
  struct Options {
    /// New participants from one address within 15 minutes, as many as a lecture hall holds.
    int joins_by_address = 300;
    std::chrono::seconds session_life = std::chrono::hours(2);
    RecordingLimits recordings{2 << 20, 128 << 20};
  };
  struct Parts {
    StudyStore& studies;
    ParticipantStore& store;
    DataSets& data_sets;
    AccountStore& accounts;
    RenderTime& render_time;
    Placement& placement;
    const Clock& clock;
    /// Shared by all processes of the API, so that they count joins together. Not in the database,
    /// so that nobody can find from it the addresses whose hashes are stored.
    const SealingKey& key;
  };
  struct Joined {
    Participation participation;
    ParticipantStore::Answered answered;
  };
  struct Opened {
    std::string session_id, stream_url;
    Time expires_at;
  };

  /// `scene_bytes` serialises the JSON of a scene.
  Participations(const Parts& parts, Options options,
                 std::function<std::string(const std::string& scene)> scene_bytes)
      : parts_(parts), options_(options), scene_bytes_(std::move(scene_bytes)) {}

  Outcome<ParticipantStore::Invitation> invitation(const std::string& token);
  /// Returns kNotFound for an unknown token with an unknown key, kStudyClosed, kStudyFull,
  /// kTooManyAttempts, or kParticipationEnded for the key of a participant who withdrew.
  Outcome<Joined> join(const std::string& token, const std::string& key,
                       const std::string& language, bool record, const Client& client);
  /// Joins the researcher's own study, also a draft, for a day and without being counted.
  Outcome<Joined> preview(const Principal& who, const std::string& study_id,
                          const std::string& key);

  // The following return kParticipationEnded for an unknown key, which includes that of a
  // participant who withdrew, and kStudyClosed once answers are no longer accepted.
  Outcome<void> answer(const std::string& key, StudyAnswer answer, const nlohmann::json& value);
  Outcome<StudyPicture> picture(const std::string& key, const std::string& picture_id);
  /// Opens the session of a step with a view. Its rendering time is the researcher's.
  Outcome<Opened> visit(const std::string& key, const std::string& step);
  /// Returns kForbidden unless the participant agreed to it.
  Outcome<void> record(const std::string& key, const std::string& step, const std::string& body);
  /// Checks before the body of a recording is received that it would be accepted.
  Outcome<void> may_record(const std::string& key);
  Outcome<void> finish(const std::string& key);
  /// Succeeds for every key, also after the study was closed.
  Outcome<void> withdraw(const std::string& key);

 private:
  Outcome<Participation> find_open(const std::string& key);
  Outcome<Joined> add(const std::string& study_id, const Participant& participant,
                      const std::optional<Time>& preview_until);
  /// Counts a new participant for their address, once for each key.
  Outcome<void> check_address(const std::string& key, const Client& client);
  std::string secret_hash(const std::string& text) const;
  Outcome<void> check_render_time(const Participation& participation, bool known);
  /// Records the session in place of the participant's earlier one, which it ends.
  Outcome<void> replace_session(const Participant& participant, const std::string& session,
                                Time expires_at);

  Parts parts_;
  Options options_;
  std::function<std::string(const std::string&)> scene_bytes_;
};

}  // namespace diaphane::api
