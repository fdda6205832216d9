#include "api/presets/recording_format.h"
#include "api/presets/routes.h"
#include "api/routing/representations.h"
#include "api/routing/route_parts.h"
#include "common/try.h"

namespace diaphane::api {

namespace {

Outcome<Response> list_recordings(Recordings& recordings, const Principal& who) {
  const auto mine = recordings.list(who);
  DIAPHANE_TRY(mine);
  nlohmann::ordered_json body{{"consent", mine->consent},
                              {"items", nlohmann::ordered_json::array()}};
  for (const Recording& one : mine->recordings) {
    body["items"].push_back({{"id", one.id},
                             {"events", one.events},
                             {"duration_ms", one.duration_ms},
                             {"created_at", rfc3339(one.created_at)},
                             {"expires_at", rfc3339(one.expires_at)}});
  }
  return json_response(200, body);
}

}  // namespace

std::vector<Route> recording_routes(Recordings& recordings) {
  const auto list = [&recordings](const Request&, const Principal& who) {
    return list_recordings(recordings, who);
  };
  const auto consent = [&recordings](bool given) {
    return [&recordings, given](const Request&, const Principal& who) {
      return answer(recordings.give_consent(who, given));
    };
  };
  const auto add = [&recordings](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    Fields in(request, kMostRecordingValues);
    Recording recording = read_recording(in);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto id = recordings.add(who, std::move(recording));
    DIAPHANE_TRY(id);
    return json_response(201, {{"id", *id}}).with("Location", "/v1/recordings/" + *id);
  };
  const auto get = [&recordings](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    const auto found = recordings.find(who, request.parameter("recording_id"));
    DIAPHANE_TRY(found);
    Response response;
    response.status = 200;
    response.content_type = "application/json";
    response.body = found->body;
    return response;
  };
  const auto remove = [&recordings](const Request& request, const Principal& who) {
    return answer(recordings.remove(who, request.parameter("recording_id")));
  };
  const std::string one = "/v1/recordings/{recording_id}";
  return {
      {"GET", "/v1/recordings", "listRecordings", Access::kPerson, list, {}},
      {"POST", "/v1/recordings", "createRecording", Access::kPerson, add, {}},
      {"POST", "/v1/recording-consent", "giveRecordingConsent", Access::kPerson, consent(true), {}},
      {"DELETE",
       "/v1/recording-consent",
       "takeRecordingConsentBack",
       Access::kPerson,
       consent(false),
       {}},
      {"GET", one, "getRecording", Access::kPerson, get, {}},
      {"DELETE", one, "deleteRecording", Access::kPerson, remove, {}},
  };
}

}  // namespace diaphane::api
