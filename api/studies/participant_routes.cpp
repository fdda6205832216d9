#include <algorithm>

#include "api/presets/recording_format.h"
#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/routing/route_parts.h"
#include "api/studies/routes.h"
#include "api/studies/study_format.h"

namespace diaphane::api {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr std::int64_t kLongestStepMs = 86'400'000;
constexpr std::int64_t kMostSequence = kSeeds - 1;

/// The key of a participant and another text of a request's body.
struct KeyAnd {
  std::string key, other;
};

Outcome<KeyAnd> key_and(const Request& request, const std::string& name) {
  Fields in(request);
  KeyAnd read{in.text("key", 64, 64), in.text(name, 1, 40)};
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  return read;
}

Outcome<std::string> key_in(const Request& request) {
  Fields in(request);
  std::string key = in.text("key", 64, 64);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  return key;
}

Outcome<Response> invitation(Participations& participations, const Request& request) {
  Fields in(request);
  const std::string token = in.text("token", 1, 64);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto found = participations.invitation(token);
  DIAPHANE_TRY(found);
  const json definition = json::parse(found->study.content.definition);
  const json& consent = definition["steps"][0]["text"];
  ordered_json languages = ordered_json::array();
  for (const std::string_view one : kLanguages) {
    if (consent.contains(std::string(one))) languages.push_back(one);
  }
  return json_response(
      200, {{"title", definition["title"]},
            {"languages", languages},
            {"consent", consent},
            {"record", definition["record"]},
            {"open", found->open},
            {"places_left", std::max(0, found->study.content.places - found->study.joined)},
            {"steps", definition["steps"].size()},
            {"researcher", found->researcher}});
}

Outcome<Response> join_study(Participations& participations, const Request& request,
                             const Principal& who) {
  Fields in(request);
  const std::string token = in.text("token", 1, 64);
  const std::string key = in.text("key", 64, 64);
  const std::string language = in.choice("language", kLanguages);
  const bool record = in.boolean("record");
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto joined = participations.join(token, key, language, record, who.client);
  DIAPHANE_TRY(joined);
  return joined_response(*joined);
}

Outcome<Response> store_answer(Participations& participations, const Request& request) {
  Fields in(request);
  const std::string key = in.text("key", 64, 64);
  StudyAnswer given;
  given.step = in.text("step", 1, 40);
  const json value = in.any("value");
  if (!value.is_object()) in.wrong("value", "must be an object");
  given.duration_ms = in.integer("duration_ms", 0, kLongestStepMs);
  given.sequence = in.integer("sequence", 0, kMostSequence);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  return answer(participations.answer(key, std::move(given), value));
}

Outcome<Response> send_picture(Participations& participations, const Request& request) {
  const auto read = key_and(request, "picture");
  DIAPHANE_TRY(read);
  auto found = participations.picture(read->key, read->other);
  DIAPHANE_TRY(found);
  Response response;
  response.content_type = found->type;
  response.body = std::move(found->bytes);
  return response;
}

Outcome<Response> open_view(Participations& participations, const Request& request) {
  const auto read = key_and(request, "step");
  DIAPHANE_TRY(read);
  const auto opened = participations.visit(read->key, read->other);
  DIAPHANE_TRY(opened);
  return json_response(201, {{"session_id", opened->session_id},
                             {"stream_url", opened->stream_url},
                             {"expires_at", rfc3339(opened->expires_at)}});
}

Outcome<Response> store_recording(Participations& participations, const Request& request) {
  Fields in(request, kMostRecordingValues);
  const std::string key = in.text("key", 64, 64);
  const std::string step = in.text("step", 1, 40);
  const json& given = in.any("recording");
  if (!given.is_object()) in.wrong("recording", "must be an object");
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  Request part = request;
  part.body = given.dump();
  Fields inner(part, kMostRecordingValues);
  const Recording recording = read_recording(inner);
  if (auto wrong = inner.finish()) {
    for (FieldProblem& one : wrong->fields) one.field = "recording." + one.field;
    return tl::unexpected(*wrong);
  }
  return answer(participations.record(key, step, recording.body));
}

/// Permits a large body only to a participant who agreed to a recording. Their key is then in the
/// header Authorization as well, because the body is not yet there.
Outcome<void> check_recording(Participations& participations, const Request& request,
                              std::int64_t bytes) {
  constexpr std::string_view kBearer = "Bearer ";
  if (bytes <= kAnyoneBodyBytes) return {};
  const std::string_view given = request.header("authorization");
  if (!given.starts_with(kBearer)) {
    return refuse(ProblemKind::kBodyTooLarge,
                  "A recording of more than 16 KiB needs the participant's key in the "
                  "Authorization header.");
  }
  return participations.may_record(std::string(given.substr(kBearer.size())));
}

}  // namespace

Response joined_response(const Participations::Joined& joined) {
  const auto& [participation, answered] = joined;
  return json_response(
      201, {{"seed", participation.participant.seed},
            {"definition", definition_for_participants(participation.study.content.definition)},
            {"answered", answered.steps},
            {"sequence", answered.sequence}});
}

std::vector<Route> participant_routes(Participations& participations) {
  const auto invite = [&participations](const Request& request, const Principal&) {
    return invitation(participations, request);
  };
  const auto join_one = [&participations](const Request& request, const Principal& who) {
    return join_study(participations, request, who);
  };
  const auto answer_one = [&participations](const Request& request, const Principal&) {
    return store_answer(participations, request);
  };
  const auto picture = [&participations](const Request& request, const Principal&) {
    return send_picture(participations, request);
  };
  const auto visit = [&participations](const Request& request, const Principal&) {
    return open_view(participations, request);
  };
  const auto record = [&participations](const Request& request, const Principal&) {
    return store_recording(participations, request);
  };
  const auto check = [&participations](const Request& request, const Principal&,
                                       std::int64_t bytes) {
    return check_recording(participations, request, bytes);
  };
  const auto finish = [&participations](const Request& request,
                                        const Principal&) -> Outcome<Response> {
    const auto key = key_in(request);
    DIAPHANE_TRY(key);
    return answer(participations.finish(*key));
  };
  const auto withdraw = [&participations](const Request& request,
                                          const Principal&) -> Outcome<Response> {
    const auto key = key_in(request);
    DIAPHANE_TRY(key);
    return answer(participations.withdraw(*key));
  };
  const std::string all = "/v1/study/";
  constexpr Access kWho = Access::kAnyone;
  return {
      {"POST", all + "invitation", "getStudyInvitation", kWho, invite, {}},
      {"POST", all + "participants", "joinStudy", kWho, join_one, {}},
      {"POST", all + "answers", "answerStudy", kWho, answer_one, {}},
      {"POST", all + "pictures", "getParticipantPicture", kWho, picture, {}},
      {"POST", all + "visits", "createStudyVisit", kWho, visit, {}},
      {"POST",
       all + "recordings",
       "addStudyRecording",
       Access::kParticipant,
       record,
       {},
       1024 * 1024,
       check},
      {"POST", all + "finish", "finishStudy", kWho, finish, {}},
      {"POST", all + "withdrawal", "withdrawFromStudy", kWho, withdraw, {}},
  };
}

}  // namespace diaphane::api
