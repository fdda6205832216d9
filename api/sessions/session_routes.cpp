#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/sessions/routes.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

nlohmann::ordered_json to_json(const Sessions::Stream& stream) {
  return {{"session_id", stream.session_id}, {"stream_url", stream.stream_url}};
}

nlohmann::ordered_json to_json(const SessionInfo& session) {
  nlohmann::ordered_json json{
      {"session_id", session.id}, {"data_set_id", session.data_set_id}, {"over", nullptr}};
  if (!session.over.empty()) json["over"] = session.over;
  return json;
}

nlohmann::ordered_json to_json(const ErrorCurve& curve) {
  auto points = nlohmann::ordered_json::array();
  for (const ErrorCurve::Point& point : curve.points) {
    points.push_back(
        {{"samples", point.samples}, {"seconds", point.seconds}, {"error", point.error}});
  }
  return {{"epoch", curve.epoch}, {"points", std::move(points)}};
}

}  // namespace

std::vector<Route> session_routes(Sessions& sessions) {
  const auto list = [&sessions](const Request&, const Principal& who) -> Outcome<Response> {
    const auto found = sessions.list(who);
    DIAPHANE_TRY(found);
    nlohmann::ordered_json body;
    body["items"] = nlohmann::ordered_json::array();
    for (const SessionInfo& session : *found) body["items"].push_back(to_json(session));
    return json_response(200, body);
  };
  const auto create = [&sessions](const Request& request,
                                  const Principal& who) -> Outcome<Response> {
    const auto key = idempotency_key(request);
    DIAPHANE_TRY(key);
    Fields in(request);
    const std::string data_set_id = in.text("data_set_id", 1, 64);
    const std::string over = in.is_null("over") ? "" : in.text_or("over", "", 64);
    if (!over.empty() && over == data_set_id) in.wrong("over", "must be another scan");
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto stream = sessions.open(who, data_set_id, over, *key);
    DIAPHANE_TRY(stream);
    return json_response(201, to_json(*stream))
        .with("Location", "/v1/sessions/" + stream->session_id);
  };
  const auto get = [&sessions](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto found = sessions.find(who, request.parameter("session_id"));
    DIAPHANE_TRY(found);
    return json_response(200, to_json(*found));
  };
  const auto end = [&sessions](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto done = sessions.end(who, request.parameter("session_id"));
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const auto ticket = [&sessions](const Request& request,
                                  const Principal& who) -> Outcome<Response> {
    const auto stream = sessions.ticket(who, request.parameter("session_id"));
    DIAPHANE_TRY(stream);
    return json_response(201, to_json(*stream));
  };
  const auto error_curve = [&sessions](const Request& request,
                                       const Principal& who) -> Outcome<Response> {
    const auto curve = sessions.error_curve(who, request.parameter("session_id"));
    DIAPHANE_TRY(curve);
    return json_response(200, to_json(*curve));
  };
  const std::string one = "/v1/sessions/{session_id}";
  return {
      {"GET", "/v1/sessions", "listSessions", Access::kPerson, list, {}},
      {"POST", "/v1/sessions", "createSession", Access::kPerson, create, {}},
      {"GET", one, "getSession", Access::kPerson, get, {}},
      {"DELETE", one, "endSession", Access::kPerson, end, {}},
      {"GET", one + "/error-curve", "getErrorCurve", Access::kPerson, error_curve, {}},
      {"POST", one + "/tickets", "createTicket", Access::kPerson, ticket, {}},
  };
}

}  // namespace diaphane::api
