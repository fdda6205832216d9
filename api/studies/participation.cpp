#include "api/studies/participation.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "api/shared/secrets.h"
#include "api/studies/answers.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

using nlohmann::json;

std::string hash_of(const std::string& key) { return blake2b("participant\n" + key); }

tl::unexpected<Problem> participation_ended() {
  return refuse(ProblemKind::kParticipationEnded,
                "Your participation has ended and your answers have been deleted, or this link is "
                "not valid.");
}

tl::unexpected<Problem> study_closed() {
  return refuse(ProblemKind::kStudyClosed, "This study is closed. Thank you for your interest.");
}

tl::unexpected<Problem> study_full() {
  return refuse(ProblemKind::kStudyFull, "All places of this study are taken.");
}

/// The problem of a change by a participant that the store refused.
tl::unexpected<Problem> participant_problem(const Error& error) {
  if (error.code == ErrorCode::kNotFound) return participation_ended();
  if (error.code == ErrorCode::kConflict) return study_closed();
  return refuse(error);
}

tl::unexpected<Problem> no_such_invitation() {
  return refuse(ProblemKind::kNotFound, "This link is invalid or has been replaced.");
}

/// Returns a seed below 2^53.
std::int64_t new_seed() {
  const std::string digits = random_hex(8);
  std::uint64_t seed = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), seed, 16);
  return static_cast<std::int64_t>(seed % static_cast<std::uint64_t>(kSeeds));
}

Participant new_participant(const std::string& key, const std::string& language, bool record,
                            Time now) {
  Participant participant;
  participant.id = new_id();
  participant.key_hash = hash_of(key);
  participant.language = language;
  participant.seed = new_seed();
  participant.day = utc_text(now, "%Y-%m-%d");
  participant.recorded = record;
  return participant;
}

tl::unexpected<Problem> another_view() {
  return refuse(ProblemKind::kBusy, "Another view is being opened. Try again in a moment.",
                std::chrono::seconds(1));
}

tl::unexpected<Problem> no_recording() {
  return refuse(ProblemKind::kForbidden, "This participant did not agree to a recording.");
}

Outcome<json> step_of(const Participation& participation, const std::string& id) {
  const json definition = json::parse(participation.study.content.definition);
  const json* step = find_step(definition, id);
  if (!step) return refuse_field("step", "is not a step of this study");
  return *step;
}

}  // namespace

Outcome<ParticipantStore::Invitation> Participations::invitation(const std::string& token) {
  if (!is_token(token)) return no_such_invitation();
  auto found = parts_.store.invitation(blake2b(token), parts_.clock.wall());
  if (!found && found.error().code == ErrorCode::kNotFound) return no_such_invitation();
  if (!found) return refuse(found.error());
  return *std::move(found);
}

std::string Participations::secret_hash(const std::string& text) const {
  return blake2b(parts_.key.mac("study\n" + text));
}

Outcome<void> Participations::check_address(const std::string& key, const Client& client) {
  constexpr std::chrono::minutes kWindow{15};
  // The time of joining is not stored more precisely than the window.
  const Time window =
      std::chrono::floor<std::chrono::duration<int, std::ratio<900>>>(parts_.clock.wall());
  const std::string once = secret_hash("key\n" + key);
  const auto counted = parts_.accounts.note_attempt({{once, 1, kWindow}}, window);
  if (!counted) return refuse(counted.error());
  if (*counted) return {};
  const auto wait = parts_.accounts.note_attempt(
      {{secret_hash("address\n" + client.address), options_.joins_by_address, kWindow}}, window);
  if (!wait || *wait) (void)parts_.accounts.forget_attempts(once, window);
  if (!wait) return refuse(wait.error());
  if (!*wait) return {};
  return refuse(ProblemKind::kTooManyAttempts,
                "Too many people from your network have joined. Try again later.", **wait);
}

Outcome<Participations::Joined> Participations::add(const std::string& study_id,
                                                    const Participant& participant,
                                                    const std::optional<Time>& preview_until) {
  auto joined = parts_.store.join(study_id, participant, preview_until, parts_.clock.wall());
  if (!joined) {
    const Error& error = joined.error();
    if (error.code == ErrorCode::kNotFound) return no_such_invitation();
    if (error.code == ErrorCode::kConflict && error.field.empty()) return study_closed();
    if (error.code == ErrorCode::kConflict && error.field == "withdrawn") {
      return participation_ended();
    }
    if (error.code == ErrorCode::kTooMany) return study_full();
    return refuse(error);
  }
  auto answered = parts_.store.answered(joined->participant.id);
  if (!answered) return refuse(answered.error());
  return Joined{*std::move(joined), *std::move(answered)};
}

Outcome<Participations::Joined> Participations::join(const std::string& token,
                                                     const std::string& key,
                                                     const std::string& language, bool record,
                                                     const Client& client) {
  if (!is_token(key)) return refuse_field("key", "must be 64 hexadecimal digits");
  const auto now = parts_.clock.wall();
  const auto known = parts_.store.find(hash_of(key), now);
  if (!known && known.error().code != ErrorCode::kNotFound) return refuse(known.error());
  const auto invited = invitation(token);
  // Somebody who joined with an earlier link continues.
  if (known && !invited && invited.error().kind == ProblemKind::kNotFound &&
      !known->participant.preview) {
    return add(known->study.id, known->participant, std::nullopt);
  }
  DIAPHANE_TRY(invited);
  if (!known) {
    if (!invited->open) return study_closed();
    if (invited->study.joined >= invited->study.content.places) return study_full();
    DIAPHANE_TRY(check_address(key, client));
  }
  const bool recorded =
      record && json::parse(invited->study.content.definition).value("record", false);
  return add(invited->study.id, new_participant(key, language, recorded, now), std::nullopt);
}

Outcome<Participations::Joined> Participations::preview(const Principal& who,
                                                        const std::string& study_id,
                                                        const std::string& key) {
  if (!is_token(key)) return refuse_field("key", "must be 64 hexadecimal digits");
  const auto now = parts_.clock.wall();
  const auto mine = is_id(study_id) ? parts_.studies.find(who.user_id, study_id, now)
                                    : Result<Study>(fail(ErrorCode::kNotFound, ""));
  if (!mine && mine.error().code == ErrorCode::kNotFound) {
    return refuse(ProblemKind::kNotFound, "Study not found.");
  }
  if (!mine) return refuse(mine.error());
  const std::string language = who.language == Language::kGerman ? "de" : "en";
  return add(study_id, new_participant(key, language, false, now), now + Studies::kPreviewLife);
}

Outcome<Participation> Participations::find_open(const std::string& key) {
  if (!is_token(key)) return participation_ended();
  auto found = parts_.store.find(hash_of(key), parts_.clock.wall());
  if (!found && found.error().code == ErrorCode::kNotFound) return participation_ended();
  if (!found) return refuse(found.error());
  if (!found->open) return study_closed();
  return *std::move(found);
}

Outcome<void> Participations::answer(const std::string& key, StudyAnswer answer,
                                     const json& value) {
  const auto participation = find_open(key);
  DIAPHANE_TRY(participation);
  const auto step = step_of(*participation, answer.step);
  DIAPHANE_TRY(step);
  auto kept = check_answer(*step, value);
  DIAPHANE_TRY(kept);
  answer.value = *std::move(kept);
  const auto done = parts_.store.answer(hash_of(key), answer, parts_.clock.wall());
  if (!done) return participant_problem(done.error());
  return {};
}

Outcome<StudyPicture> Participations::picture(const std::string& key,
                                              const std::string& picture_id) {
  const auto participation = find_open(key);
  DIAPHANE_TRY(participation);
  auto found = parts_.studies.picture(participation->study.id, picture_id);
  if (!found && found.error().code == ErrorCode::kNotFound) {
    return refuse(ProblemKind::kNotFound, "Picture not found.");
  }
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<void> Participations::check_render_time(const Participation& participation, bool known) {
  Principal researcher;
  researcher.user_id = participation.study.owner_id;
  auto allowed =
      known ? parts_.render_time.may_go_on(researcher) : parts_.render_time.may_open(researcher);
  // The researcher's account is none of the participant's business.
  if (!allowed && allowed.error().kind == ProblemKind::kRenderTimeSpent) {
    return refuse(ProblemKind::kBusy,
                  "This study can't show scans at the moment. Try again later or tell the "
                  "researcher.",
                  std::chrono::minutes(5));
  }
  return allowed;
}

Outcome<void> Participations::replace_session(const Participant& participant,
                                              const std::string& session, Time expires_at) {
  const std::string& earlier = participant.session_id;
  // A participant has one session, because it takes one of the researcher's places.
  if (!earlier.empty() && earlier != session) {
    if (const auto ended = parts_.placement.end(earlier); !ended) return refuse(ended.error());
  }
  const auto noted = parts_.store.note_session(participant.key_hash, earlier, session, expires_at);
  if (!noted && noted.error().code == ErrorCode::kNotFound) return participation_ended();
  if (!noted && noted.error().code == ErrorCode::kConflict) return another_view();
  if (!noted) return refuse(noted.error());
  return {};
}

Outcome<Participations::Opened> Participations::visit(const std::string& key,
                                                      const std::string& step_id) {
  const auto participation = find_open(key);
  DIAPHANE_TRY(participation);
  const auto step = step_of(*participation, step_id);
  DIAPHANE_TRY(step);
  if (!step->contains("view")) return refuse_field("step", "has no view");
  const auto& [participant, study, open] = *participation;
  const json& view = (*step)["view"];
  const auto data_set =
      find_for_study(parts_.data_sets, study.owner_id, view["data_set_id"].get<std::string>());
  DIAPHANE_TRY(data_set);
  const std::string session = id_from("study\n" + participant.id + "\n" + step_id);
  DIAPHANE_TRY(check_render_time(*participation, session == participant.session_id));
  // Stored in whole hours, because the time at which somebody took part is not stored.
  const Time latest =
      std::chrono::ceil<std::chrono::hours>(parts_.clock.wall() + options_.session_life);
  const Time expires = participant.preview ? latest : std::min(study.content.ends_at, latest);
  // Noted before the placement, so that whoever closes the study ends the session.
  DIAPHANE_TRY(replace_session(participant, session, expires));
  // The session is the participant's, so that the researcher can't watch it.
  PlaceRequest request{session, participant.id, data_set->id};
  request.charged_to = study.owner_id;
  request.first_scene = scene_bytes_(view["scene"].dump());
  request.viewer = SessionViewer::kLinkVisitor;
  const auto placed = parts_.placement.place(request);
  if (!placed && placed.error().code == ErrorCode::kUnavailable && parts_.placement.reachable()) {
    return refuse(ProblemKind::kNoWorker, placed.error().message, std::chrono::seconds(2));
  }
  if (!placed && placed.error().code == ErrorCode::kTooMany) {
    return refuse(ProblemKind::kBusy,
                  "As many people as possible are taking part right now. Please wait a moment.",
                  std::chrono::seconds(5));
  }
  if (!placed) return refuse(placed.error());
  // The study may have been closed or another session opened during the placement, by a request
  // that did not see this session.
  const auto still = find_open(key);
  const bool current = still && still->participant.session_id == session;
  if (!current) (void)parts_.placement.end(session);
  DIAPHANE_TRY(still);
  if (!current) return another_view();
  return Opened{session, "/stream?ticket=" + placed->ticket, expires};
}

Outcome<void> Participations::may_record(const std::string& key) {
  const auto participation = find_open(key);
  DIAPHANE_TRY(participation);
  if (!participation->participant.recorded) return no_recording();
  return {};
}

Outcome<void> Participations::record(const std::string& key, const std::string& step,
                                     const std::string& body) {
  const auto participation = find_open(key);
  DIAPHANE_TRY(participation);
  if (!participation->participant.recorded) return no_recording();
  DIAPHANE_TRY(step_of(*participation, step));
  const auto done = parts_.store.add_recording(hash_of(key), step, body, options_.recordings,
                                               parts_.clock.wall());
  if (!done) return participant_problem(done.error());
  return {};
}

Outcome<void> Participations::finish(const std::string& key) {
  const auto participation = find_open(key);
  DIAPHANE_TRY(participation);
  const auto done = parts_.store.finish(hash_of(key));
  if (!done && done.error().code == ErrorCode::kNotFound) return participation_ended();
  if (!done) return refuse(done.error());
  const std::string& session = participation->participant.session_id;
  if (!session.empty() && parts_.placement.end(session)) {
    (void)parts_.studies.forget_session(session);
  }
  return {};
}

Outcome<void> Participations::withdraw(const std::string& key) {
  if (!is_token(key)) return {};
  const auto session = parts_.store.withdraw(hash_of(key));
  if (!session) return refuse(session.error());
  // If this fails, the background task ends the session (StudyStore::expire).
  if (!session->empty() && parts_.placement.end(*session)) {
    (void)parts_.studies.forget_session(*session);
  }
  return {};
}

}  // namespace diaphane::api
