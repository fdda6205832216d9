#include "api/presets/preset_format.h"
#include "api/presets/routes.h"
#include "api/routing/annotation_fields.h"
#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/routing/route_parts.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

Response preset_response(int status, const Preset& preset) {
  return json_response(status, with_scene(preset)).with("ETag", etag_of(preset));
}

Response made(const Preset& preset) {
  return preset_response(201, preset).with("Location", "/v1/presets/" + preset.id);
}

/// Reads the optional field `annotations`. Returns an empty string if it is absent or null.
std::string read_preset_annotations(Fields& in) {
  if (!in.has("annotations") || in.is_null("annotations")) return {};
  return read_annotations(in, "annotations");
}

Outcome<Response> create_preset(Presets& presets, const Request& request, const Principal& who) {
  const auto key = idempotency_key(request);
  DIAPHANE_TRY(key);
  DIAPHANE_TRY(check_size(request));
  Fields in(request);
  Preset preset;
  preset.name = in.name("name", 1, 60);
  preset.scene = read_scene(in);
  preset.annotations = read_preset_annotations(in);
  read_format_version(in);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto saved = presets.add(who, request.parameter("data_set_id"), std::move(preset), *key);
  DIAPHANE_TRY(saved);
  return made(*saved);
}

Outcome<Response> import_preset(Presets& presets, const Request& request, const Principal& who) {
  const auto key = idempotency_key(request);
  DIAPHANE_TRY(key);
  DIAPHANE_TRY(check_size(request));
  auto preset = read_preset_xml(request);
  DIAPHANE_TRY(preset);
  const auto saved = presets.add(who, request.parameter("data_set_id"), *std::move(preset), *key);
  DIAPHANE_TRY(saved);
  return made(*saved);
}

Outcome<Response> change(Presets& presets, const Request& request, const Principal& who) {
  DIAPHANE_TRY(check_size(request));
  Fields in(request);
  PresetChange what;
  if (in.has("name")) what.name = in.name("name", 1, 60);
  if (in.has("scene")) what.scene = read_scene(in);
  if (in.has("annotations")) what.annotations = read_preset_annotations(in);
  read_format_version(in);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const std::string& id = request.parameter("preset_id");
  // For a preset that the user must not see, returns 404 before other errors of the request.
  DIAPHANE_TRY(presets.find(who, id));
  const auto version = version_in_if_match(request);
  DIAPHANE_TRY(version);
  const auto changed = presets.change(who, id, *version, what);
  DIAPHANE_TRY(changed);
  return preset_response(200, *changed);
}

std::vector<Route> routes_of_one(Presets& presets) {
  const auto get = [&presets](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto found = presets.find(who, request.parameter("preset_id"));
    DIAPHANE_TRY(found);
    return preset_response(200, *found);
  };
  const auto get_xml = [&presets](const Request& request,
                                  const Principal& who) -> Outcome<Response> {
    const auto found = presets.find(who, request.parameter("preset_id"));
    DIAPHANE_TRY(found);
    Response response;
    response.content_type = "application/xml";
    response.body = to_xml(*found);
    return std::move(response)
        .with("ETag", etag_of(*found))
        .with("Content-Disposition", "attachment; filename=\"preset.xml\"");
  };
  const auto patch = [&presets](const Request& request, const Principal& who) {
    return change(presets, request, who);
  };
  const auto remove = [&presets](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    const std::string& id = request.parameter("preset_id");
    DIAPHANE_TRY(presets.find(who, id));
    const auto version = version_in_if_match(request);
    DIAPHANE_TRY(version);
    return answer(presets.remove(who, id, *version));
  };
  const auto vote = [&presets](const Request& request, const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const auto value = static_cast<int>(in.integer("value", -1, 1));
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    const auto now = presets.vote(who, request.parameter("preset_id"), value);
    DIAPHANE_TRY(now);
    return json_response(200, {{"votes", now->votes}, {"my_vote", now->my_vote}});
  };
  const std::string one = "/v1/presets/{preset_id}";
  return {
      {"GET", one, "getPreset", Access::kAnyoneOrPerson, get, {}},
      {"GET", one + "/xml", "exportPreset", Access::kAnyoneOrPerson, get_xml, {}},
      {"PATCH", one, "changePreset", Access::kPerson, patch, {}},
      {"DELETE", one, "deletePreset", Access::kPerson, remove, {}},
      {"POST", one + "/vote", "voteForPreset", Access::kPerson, vote, {}},
  };
}

std::vector<Route> routes_of_data_set(Presets& presets, PresetPictures& pictures) {
  const auto list = [&presets](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto found = presets.list(who, request.parameter("data_set_id"));
    DIAPHANE_TRY(found);
    nlohmann::ordered_json body;
    body["items"] = nlohmann::ordered_json::array();
    for (const Preset& preset : *found) body["items"].push_back(to_json(preset));
    return json_response(200, body);
  };
  const auto add = [&presets](const Request& request, const Principal& who) {
    return create_preset(presets, request, who);
  };
  const auto import = [&presets](const Request& request, const Principal& who) {
    return import_preset(presets, request, who);
  };
  const auto set_default = [&presets](const Request& request,
                                      const Principal& who) -> Outcome<Response> {
    Fields in(request);
    const std::string id = in.is_null("preset_id") ? "" : in.text("preset_id", 1, 64);
    if (auto wrong = in.finish()) return tl::unexpected(*wrong);
    return answer(presets.set_default(who, request.parameter("data_set_id"), id));
  };
  const auto thumbnail = [&pictures](const Request& request,
                                     const Principal& who) -> Outcome<Response> {
    const auto path =
        pictures.get(who, request.parameter("data_set_id"), request.parameter("preset_id"));
    DIAPHANE_TRY(path);
    return cached_picture(*path);
  };
  const std::string of_data_set = "/v1/data-sets/{data_set_id}";
  const std::string all = of_data_set + "/presets";
  return {
      {"GET", all, "listPresets", Access::kAnyoneOrPerson, list, {}},
      {"POST", all, "createPreset", Access::kPerson, add, {}},
      {"POST", all + "/xml", "importPreset", Access::kPerson, import, {}},
      {"GET",
       all + "/{preset_id}/thumbnail",
       "getPresetThumbnail",
       Access::kAnyoneOrPerson,
       thumbnail,
       {}},
      {"POST",
       of_data_set + "/default-preset",
       "setDefaultPreset",
       Access::kPerson,
       set_default,
       {}},
  };
}

}  // namespace

std::vector<Route> preset_routes(Presets& presets, PresetPictures& pictures) {
  return join({routes_of_data_set(presets, pictures), routes_of_one(presets)});
}

}  // namespace diaphane::api
