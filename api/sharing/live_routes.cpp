#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/sharing/routes.h"
#include "common/try.h"

namespace diaphane::api {

std::vector<Route> live_routes(LiveLinks& links, const RequestRouter& router) {
  const auto make = [&links, &router](const Request& request,
                                      const Principal& who) -> Outcome<Response> {
    const auto once = idempotency_scope_of(request, router);
    DIAPHANE_TRY(once);
    bool slices = false;
    // The body is optional: without its type, there is none.
    if (!request.body.empty() || !request.header("content-type").empty()) {
      Fields in(request);
      slices = in.optional_boolean("slices").value_or(false);
      if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    }
    const auto token = links.make(who, request.parameter("session_id"), slices, *once);
    DIAPHANE_TRY(token);
    return json_response(201, {{"token", *token}, {"path", "/join#" + *token}});
  };
  const auto end = [&links](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto done = links.end(who, request.parameter("session_id"));
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const auto join = [&links](const Request& request, const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string token = in.text("token", 64, 64);
    const std::string key = in.text("key", 64, 64);
    const std::string name = in.text_or("name", "", 64);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto joined = links.join(token, key, name, who.client);
    DIAPHANE_TRY(joined);
    return json_response(
        201, {{"participant", joined->participant}, {"stream_url", joined->stream_url}});
  };
  const std::string of_session = "/v1/sessions/{session_id}/links";
  return {
      {"POST", of_session, "createLink", Access::kPerson, make, {}},
      {"DELETE", of_session, "endLinks", Access::kPerson, end, {}},
      {"POST", "/v1/join", "join", Access::kAnyone, join, {}},
  };
}

}  // namespace diaphane::api
