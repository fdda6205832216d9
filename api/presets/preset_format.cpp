#include "api/presets/preset_format.h"

#include <charconv>

#include "api/routing/representations.h"
#include "common/names.h"
#include "common/try.h"
#include "scene/annotations.h"
#include "scene/scene.h"
#include "scene/scene_xml.h"

namespace diaphane::api {
namespace {

/// Maximum serialised size. The stream carries a scene in a message of at most 64 KB.
constexpr std::size_t kMostSceneBytes = 60'000;
/// Maximum size of presets.scene (migrations/0006). JSON is larger than the serialised form.
constexpr std::size_t kMostKeptSceneBytes = 524'288;
constexpr std::size_t kLongestName = 60;

Result<std::string> checked(const diaphane::v1::Scene& scene) {
  DIAPHANE_TRY(scene::check_scene(scene, scene::no_pictures));
  if (scene.ByteSizeLong() > kMostSceneBytes) {
    return fail(ErrorCode::kInvalid, "is too large (60 KB at most)", "");
  }
  std::string kept = scene::scene_to_json(scene);
  if (kept.size() > kMostKeptSceneBytes) {
    return fail(ErrorCode::kInvalid, "is too large (512 KB at most when stored)", "");
  }
  return kept;
}

bool is_xml(std::string_view content_type) {
  const std::string_view type = content_type.substr(0, content_type.find(';'));
  return type == "application/xml" || type == "text/xml";
}

bool is_name(std::string_view text) {
  std::size_t characters = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) return false;
    characters += (byte & 0xc0) != 0x80 ? 1 : 0;
  }
  return characters >= 1 && characters <= kLongestName;
}

}  // namespace

Outcome<void> check_size(const Request& request) {
  if (request.body.size() <= kMostPresetBytes) return {};
  return refuse(ProblemKind::kBodyTooLarge, "A preset may be at most 256 KB.");
}

Result<std::string> kept_scene(const nlohmann::json& given) {
  if (!given.is_object()) return fail(ErrorCode::kInvalid, "must be an object", "");
  const auto scene = scene::scene_from_json(given.dump());
  DIAPHANE_TRY(scene);
  return checked(*scene);
}

std::string read_scene(Fields& in) {
  const nlohmann::json& given = in.any("scene");
  if (given.is_null()) {
    if (in.has("scene")) in.wrong("scene", "must be an object");
    return {};
  }
  auto kept = kept_scene(given);
  if (kept) return *std::move(kept);
  const std::string& field = kept.error().field;
  // The path of an unknown field is client input, so it is returned only if it can be a name.
  const bool plain = field.size() <= 200 && field.find_first_of("\n\r\t<>\"") == std::string::npos;
  in.wrong(field.empty() || !plain ? "scene" : "scene." + field,
           kept.error().message.substr(0, 300));
  return {};
}

void read_format_version(Fields& in) {
  if (!in.has("version")) return;
  const auto version = in.integer("version", 1, INT32_MAX);
  if (version > kPresetVersion) {
    in.wrong("version", "is newer than this server supports (1)");
  }
}

Outcome<Preset> read_preset_xml(const Request& request) {
  if (!is_xml(request.header("content-type"))) {
    return refuse(ProblemKind::kMediaType, "The body must be application/xml.");
  }
  auto read = scene::preset_from_xml(request.body);
  if (!read) return refuse_field(read.error().field, read.error().message);
  auto kept = checked(read->scene);
  if (!kept) {
    const std::string& field = kept.error().field;
    return refuse_field(field.empty() ? "preset" : field, kept.error().message);
  }
  if (!is_name(read->name)) return refuse_field("name", "must have 1 to 60 characters");
  Preset preset;
  preset.name = clean_name(read->name, kLongestName);
  if (preset.name.empty()) return refuse_field("name", "must contain visible characters");
  preset.scene = *std::move(kept);
  if (read->annotations) {
    const auto annotations = scene::check_annotations(*read->annotations);
    if (!annotations) return refuse_field("annotations", annotations.error().message);
    preset.annotations = scene::annotations_to_json(*annotations);
  }
  if (read->has_unknown) {
    // The document is kept without the marks, because they can be removed later.
    preset.kept_xml = read->annotations
                          ? scene::preset_to_xml(read->name, read->scene, request.body)
                          : request.body;
    if (preset.kept_xml.size() > scene::kMostXmlBytes) {
      return refuse_field("preset", "is too large (256 KB at most)");
    }
  }
  return preset;
}

Outcome<int> version_in_if_match(const Request& request) {
  const std::string_view given = request.header("if-match");
  if (given.empty()) {
    return refuse(ProblemKind::kPreconditionRequired,
                  "Send the preset's ETag in the If-Match header.");
  }
  int version = 0;
  if (given.size() > 2 && given.front() == '"' && given.back() == '"') {
    const char* const end = given.data() + given.size() - 1;
    const auto [last, error] = std::from_chars(given.data() + 1, end, version);
    if (error != std::errc() || last != end || version < 1) version = 0;
  }
  if (version == 0) {
    return refuse(ProblemKind::kPrecondition,
                  "The If-Match header is not a valid ETag of this preset.");
  }
  return version;
}

std::string etag_of(const Preset& preset) { return '"' + std::to_string(preset.version) + '"'; }

nlohmann::ordered_json to_json(const Preset& preset) {
  return {{"id", preset.id},
          {"data_set_id", preset.data_set_id},
          {"name", preset.name},
          {"author_name", preset.author_name},
          {"mine", preset.mine},
          {"is_default", preset.is_default},
          {"changed_since_default", preset.changed_since_default},
          {"votes", preset.votes},
          {"my_vote", preset.my_vote},
          {"etag", etag_of(preset)},
          {"taken_down", preset.taken_down
                             ? nlohmann::ordered_json{{"reason", preset.taken_down_reason}}
                             : nlohmann::ordered_json()},
          {"pictured_at", preset.pictured_at ? nlohmann::ordered_json(rfc3339(*preset.pictured_at))
                                             : nlohmann::ordered_json()},
          {"created_at", rfc3339(preset.created_at)},
          {"updated_at", rfc3339(preset.updated_at)}};
}

nlohmann::ordered_json with_scene(const Preset& preset) {
  auto json = to_json(preset);
  json["version"] = kPresetVersion;
  json["scene"] = nlohmann::ordered_json::parse(preset.scene);
  json["annotations"] = preset.annotations.empty()
                            ? nlohmann::ordered_json()
                            : nlohmann::ordered_json::parse(preset.annotations);
  return json;
}

std::string scene_bytes(const std::string& scene) {
  const auto read = scene::scene_from_json(scene);
  return read ? read->SerializeAsString() : std::string();
}

std::string to_xml(const Preset& preset) {
  // The scene was validated when it was saved. A scene of an older version may lack new fields.
  const auto scene = scene::scene_from_json(preset.scene);
  const auto annotations = scene::annotations_from_json(preset.annotations);
  return scene::preset_to_xml(preset.name, scene ? *scene : diaphane::v1::Scene{}, preset.kept_xml,
                              annotations ? &*annotations : nullptr);
}

}  // namespace diaphane::api
