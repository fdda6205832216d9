#pragma once

#include <memory>
#include <vector>

#include "api/proto/scene.pb.h"
#include "common/result.h"
#include "renderd/kernel/features.h"
#include "renderd/kernel/views.h"
#include "renderd/scene/camera.h"
#include "renderd/scene/frame.h"
#include "renderd/scene/light_textures.h"

namespace diaphane::render {

/// A scene's lights in the volume's frame. Those that are disabled or give no light are left out.
struct PreparedLights {
  std::vector<AreaLight> area;
  Float3 environment{};              ///< of those without a texture
  std::vector<EnvironmentMap> maps;  ///< those with one
  /// Shared with the scene before when the pictures are the same; nothing when there are none.
  std::shared_ptr<const PreparedTextures> textures;
};

/// `scene` has passed check_scene. kInvalid names the field of a texture that cannot be decoded.
///
/// A light is picked in proportion to its power: for that of a textured one, its radiance times the
/// mean of its texels. A sixteenth of all is spread evenly: however little of the power a light
/// has, it may be all that reaches some place.
Result<PreparedLights> prepare_lights(const diaphane::v1::Scene& scene, const CameraAxes& axes,
                                      const WorldToFrame& frame,
                                      const std::shared_ptr<const PreparedTextures>& before);

/// Of the kernel that these lights need.
Features features_of(const PreparedLights& lights);

}  // namespace diaphane::render
