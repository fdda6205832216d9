// Any bytes as a preset in JSON or XML. An accepted preset can be stored, shown and returned.
#include <google/protobuf/stubs/logging.h>

#include "api/presets/preset_format.h"
#include "scene/scene.h"
#include "scene/scene_xml.h"
#include "tests/fuzz/requests.h"

using namespace diaphane;
using namespace diaphane::api;

namespace {

void taken(const Preset& preset) {
  MUST(is_utf8(preset.name) && is_utf8(preset.scene) && is_utf8(preset.kept_xml));
  MUST(preset.scene.size() <= 524'288);
  const auto scene = scene::scene_from_json(preset.scene);
  MUST(scene && scene::check_scene(*scene, scene::no_pictures));
  MUST(scene->ByteSizeLong() <= 60'000 && !scene_bytes(preset.scene).empty());
  MUST(with_scene(preset)["scene"].is_object());
  MUST(scene::preset_from_xml(to_xml(preset)).has_value());
}

void read_json(const Request& request) {
  Fields in(request);
  Preset preset;
  preset.name = in.text("name", 1, 60);
  preset.scene = read_scene(in);
  read_format_version(in);
  if (const auto wrong = in.finish()) {
    MUST(wrong->kind != ProblemKind::kInternal);
  } else {
    taken(preset);
  }
}

void read_xml(const Request& request) {
  if (const auto preset = read_preset_xml(request)) {
    taken(*preset);
  } else {
    MUST(!preset.error().fields.empty() && !preset.error().fields.front().field.empty());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  // Suppresses a message per text that is not UTF-8, among which findings would be lost.
  static auto* const silenced = google::protobuf::SetLogHandler(nullptr);
  (void)silenced;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (text.starts_with('<')) {
    read_xml(fuzz::request_of("application/xml", text));
  } else {
    read_json(fuzz::request_of("application/json", text));
  }
  return 0;
}
