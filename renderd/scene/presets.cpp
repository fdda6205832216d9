#include "renderd/scene/presets.h"

namespace diaphane::render {

std::vector<diaphane::v1::Preset> presets_for(const volume::Header&) { return {}; }
Result<diaphane::v1::Preset> preset_for(const volume::Header& header, std::string_view name) {
  for (auto& preset : presets_for(header)) {
    if (preset.name() == name) return preset;
  }
  return fail(ErrorCode::kNotFound, "no preset has this name", "preset");
}

}  // namespace diaphane::render
