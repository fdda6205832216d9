#include "api/annotations/routes.h"
#include "api/routing/annotation_fields.h"
#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/routing/route_parts.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

constexpr std::size_t kSetNameLength = 60;
constexpr std::size_t kRevisionLength = 100;

nlohmann::ordered_json to_json(const AnnotationSet& set) {
  return {{"id", set.id},
          {"name", set.name},
          {"mine", set.mine},
          {"shown", set.shown},
          {"shared", set.shared},
          {"content", nlohmann::ordered_json::parse(set.content)},
          {"revision", revision_of(set)},
          {"created_at", rfc3339(set.created_at)},
          {"updated_at", rfc3339(set.updated_at)}};
}

Response sets_response(const std::vector<AnnotationSet>& sets) {
  nlohmann::ordered_json body;
  body["items"] = nlohmann::ordered_json::array();
  for (const AnnotationSet& one : sets) body["items"].push_back(to_json(one));
  return json_response(200, body);
}

Outcome<Response> create_set(AnnotationSets& sets, const Request& request, const Principal& who) {
  Fields in(request);
  AnnotationSet set;
  set.name = in.name("name", 1, kSetNameLength);
  set.content = read_annotations(in, "content");
  set.shown = in.optional_boolean("shown").value_or(true);
  set.shared = in.optional_boolean("shared").value_or(false);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto saved = sets.add(who, request.parameter("data_set_id"), std::move(set));
  DIAPHANE_TRY(saved);
  return json_response(201, to_json(*saved))
      .with("Location", "/v1/data-sets/" + saved->data_set_id + "/annotations/" + saved->id);
}

Outcome<Response> change_set(AnnotationSets& sets, const Request& request, const Principal& who) {
  Fields in(request);
  AnnotationChange what;
  if (in.has("name")) what.name = in.name("name", 1, kSetNameLength);
  if (in.has("content")) what.content = read_annotations(in, "content");
  if (in.has("revision")) what.revision = in.text("revision", 1, kRevisionLength);
  what.shown = in.optional_boolean("shown");
  what.shared = in.optional_boolean("shared");
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto changed =
      sets.change(who, request.parameter("data_set_id"), request.parameter("annotation_id"), what);
  DIAPHANE_TRY(changed);
  return json_response(200, to_json(*changed));
}

}  // namespace

std::vector<Route> annotation_routes(AnnotationSets& sets, Visits& visits) {
  const auto list = [&sets](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto found = sets.list(who, request.parameter("data_set_id"));
    DIAPHANE_TRY(found);
    return sets_response(*found);
  };
  const auto follow = [&sets, &visits](const Request& request,
                                       const Principal&) -> Outcome<Response> {
    Fields in(request);
    const std::string token = in.text("token", 64, 64);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto leads = visits.follow(token);
    DIAPHANE_TRY(leads);
    const auto found = sets.shared_of(leads->data_set.id);
    DIAPHANE_TRY(found);
    return sets_response(*found);
  };
  const auto add = [&sets](const Request& request, const Principal& who) {
    return create_set(sets, request, who);
  };
  const auto patch = [&sets](const Request& request, const Principal& who) {
    return change_set(sets, request, who);
  };
  const auto remove = [&sets](const Request& request, const Principal& who) {
    return answer(
        sets.remove(who, request.parameter("data_set_id"), request.parameter("annotation_id")));
  };
  const std::string all = "/v1/data-sets/{data_set_id}/annotations";
  const std::string one = all + "/{annotation_id}";
  return {
      {"GET", all, "listAnnotations", Access::kAnyoneOrPerson, list, {}},
      {"POST", "/v1/follow/annotations", "followLinkAnnotations", Access::kAnyone, follow, {}},
      {"POST", all, "createAnnotations", Access::kPerson, add, {}},
      {"PATCH", one, "changeAnnotations", Access::kPerson, patch, {}},
      {"DELETE", one, "deleteAnnotations", Access::kPerson, remove, {}},
  };
}

}  // namespace diaphane::api
