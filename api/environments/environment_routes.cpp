#include "api/environments/routes.h"
#include "api/routing/request_fields.h"
#include "api/routing/route_parts.h"
#include "common/names.h"

namespace diaphane::api {
namespace {

constexpr std::size_t kNameLength = 60;

/// Omits the private fields, such as the name, for everyone but the owner.
nlohmann::ordered_json to_json(const Environment& environment) {
  nlohmann::ordered_json body{{"id", environment.id}, {"mine", environment.mine}};
  if (environment.mine) {
    body["name"] = environment.name;
    body["bytes"] = environment.bytes;
    body["created_at"] = rfc3339(environment.created_at);
  }
  body["preview"] = environment.preview;
  return body;
}

Outcome<Response> add(Environments& environments, const Request& request, const Principal& who) {
  const auto given = request.query.find("name");
  const std::string name =
      given == request.query.end() ? std::string() : clean_name(given->second, kNameLength);
  if (name.empty()) return refuse_field("name", "must contain visible characters");
  const auto added = environments.add(who, name, request.body);
  DIAPHANE_TRY(added);
  return json_response(201, to_json(*added)).with("Location", "/v1/environments/" + added->id);
}

}  // namespace

std::vector<Route> environment_routes(Environments& environments) {
  const auto list = [&environments](const Request&, const Principal& who) -> Outcome<Response> {
    const auto found = environments.list(who);
    DIAPHANE_TRY(found);
    nlohmann::ordered_json body;
    body["items"] = nlohmann::ordered_json::array();
    for (const Environment& one : *found) body["items"].push_back(to_json(one));
    return json_response(200, body);
  };
  const auto create = [&environments](const Request& request, const Principal& who) {
    return add(environments, request, who);
  };
  const auto get = [&environments](const Request& request,
                                   const Principal& who) -> Outcome<Response> {
    const auto found = environments.find(who, request.parameter("environment_id"));
    DIAPHANE_TRY(found);
    return json_response(200, to_json(*found));
  };
  const auto rename = [&environments](const Request& request,
                                      const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string name = in.name("name", 1, kNameLength);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto renamed = environments.rename(who, request.parameter("environment_id"), name);
    DIAPHANE_TRY(renamed);
    return json_response(200, to_json(*renamed));
  };
  const auto remove = [&environments](const Request& request, const Principal& who) {
    return answer(environments.remove(who, request.parameter("environment_id")));
  };
  const std::string all = "/v1/environments", one = all + "/{environment_id}";
  return {
      {"GET", all, "listEnvironments", Access::kPerson, list, {}},
      {"POST",
       all,
       "createEnvironment",
       Access::kPerson,
       create,
       {"name"},
       Environments::kMostUpload},
      {"GET", one, "getEnvironment", Access::kAnyoneOrPerson, get, {}},
      {"PATCH", one, "renameEnvironment", Access::kPerson, rename, {}},
      {"DELETE", one, "deleteEnvironment", Access::kPerson, remove, {}},
  };
}

}  // namespace diaphane::api
