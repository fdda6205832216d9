// Any bytes as a scene in XML and, after a zero byte, as the document of a preset into which the
// scene is written. Without XML at the start: as a scene in JSON.
#include "scene/scene_xml.h"

#include <google/protobuf/stubs/logging.h>

#include <algorithm>

#include "scene/scene.h"
#include "tests/fuzz/must.h"

using namespace diaphane;

namespace {

void written(const scene::XmlPreset& preset, std::string_view kept) {
  const std::string xml = scene::preset_to_xml(preset.name, preset.scene, kept,
                                               preset.annotations ? &*preset.annotations : nullptr);
  // Indentation can make a document larger than the limit for presets, and then it is not read.
  if (xml.size() > scene::kMostXmlBytes) return;
  const auto again = scene::preset_from_xml(xml);
  MUST(again.has_value() || again.error().message.find("too many elements") != std::string::npos);
}

void read_json(std::string_view text) {
  const auto read = scene::scene_from_json(text);
  if (!read) {
    MUST(!read.error().message.empty());
    return;
  }
  (void)scene::check_scene(*read, scene::no_pictures);
  MUST(scene::scene_from_json(scene::scene_to_json(*read)).has_value());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  static auto* const silenced = google::protobuf::SetLogHandler(nullptr);
  (void)silenced;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (!text.starts_with('<')) {
    read_json(text);
    return 0;
  }
  const std::size_t gap = std::min(text.find('\0'), text.size());
  const auto preset = scene::preset_from_xml(text.substr(0, gap));
  if (!preset) {
    MUST(!preset.error().field.empty() && !preset.error().message.empty());
    return 0;
  }
  (void)scene::check_scene(preset->scene, scene::no_pictures);
  written(*preset, {});
  written(*preset, text.substr(0, gap));
  const std::string_view kept = text.substr(std::min(gap + 1, text.size()));
  if (scene::preset_from_xml(kept)) written(*preset, kept);
  return 0;
}
