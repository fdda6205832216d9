#include "api/privacy/routes.h"
#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

const char* to_text(Export::State state) {
  switch (state) {
    case Export::State::kReady:
      return "ready";
    case Export::State::kFailed:
      return "failed";
    case Export::State::kQueued:
      break;
  }
  return "queued";
}

nlohmann::ordered_json to_json(const Export& one) {
  nlohmann::ordered_json json{{"state", to_text(one.state)},
                              {"waiting", one.waiting && one.state == Export::State::kQueued},
                              {"bytes", nullptr},
                              {"created_at", rfc3339(one.created_at)},
                              {"expires_at", rfc3339(one.expires_at)}};
  if (one.state == Export::State::kReady) json["bytes"] = one.bytes;
  return json;
}

}  // namespace

std::vector<Route> privacy_routes(Exports& exports, AccountDeletion& deletion,
                                  const RequestRouter& router) {
  const auto request_one = [&exports](const Request&, const Principal& who) -> Outcome<Response> {
    const auto made = exports.request(who);
    DIAPHANE_TRY(made);
    return json_response(202, to_json(*made));
  };
  const auto get = [&exports](const Request&, const Principal& who) -> Outcome<Response> {
    const auto found = exports.find(who);
    DIAPHANE_TRY(found);
    return json_response(200, to_json(*found));
  };
  const auto remove = [&exports](const Request&, const Principal& who) -> Outcome<Response> {
    const auto done = exports.remove(who);
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const auto download = [&exports](const Request&, const Principal& who) -> Outcome<Response> {
    const auto name = exports.file(who);
    DIAPHANE_TRY(name);
    // nginx sends the file.
    Response response;
    response.content_type = "application/zip";
    return std::move(response)
        .with("X-Accel-Redirect", "/_cache/exports/" + *name)
        .with("Content-Disposition", "attachment; filename=\"diaphane-export.zip\"")
        .with("Cache-Control", "no-store");
  };
  const auto delete_account = [&deletion, &router](const Request& request,
                                                   const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string password = in.secret("password", kPasswordBytes);
    const std::string code = in.text_or("code", "", kCodeCharacters);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto done = deletion.remove(who, password, code);
    DIAPHANE_TRY(done);
    return empty_response(204).with("Set-Cookie", router.cookie(""));
  };
  constexpr auto kOwn = Access::kOwnAccount;
  return {
      {"POST", "/v1/me/export", "requestExport", kOwn, request_one, {}},
      {"GET", "/v1/me/export", "getExport", kOwn, get, {}},
      {"DELETE", "/v1/me/export", "deleteExport", kOwn, remove, {}},
      {"GET", "/v1/me/export/file", "downloadExport", kOwn, download, {}},
      {"POST", "/v1/me/deletion", "deleteAccount", kOwn, delete_account, {}},
  };
}

}  // namespace diaphane::api
