#include "common/try.h"
#include "renderd/scene/presets.h"
#include "renderd/scene/texture.h"
#include "scene/scene.h"

namespace diaphane::render {

Result<void> check_scene(const diaphane::v1::Scene& scene) {
  return scene::check_scene(scene, [](std::string_view file) -> Result<void> {
    const auto size = texture_size(file);
    DIAPHANE_TRY(size);
    return {};
  });
}

Result<diaphane::v1::Scene> scene_from_json(std::string_view json) {
  return scene::scene_from_json(json);
}

std::string scene_to_json(const diaphane::v1::Scene& scene) { return scene::scene_to_json(scene); }

}  // namespace diaphane::render
