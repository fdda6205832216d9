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

/// A scene's lights in the volume's frame, without those that are disabled or give no light.
struct PreparedLights {
  std::vector<AreaLight> area;
  Float3 environment{};              ///< sum of the environment lights without a texture
  std::vector<EnvironmentMap> maps;  ///< environment lights with a texture
  /// Shared with the previous scene if the pictures are the same; null if there are none.
  std::shared_ptr<const PreparedTextures> textures;
};

/// Prepares the lights of a scene, which must have passed check_scene(). Fails with kInvalid and
/// the name of the field if a texture cannot be decoded.
///
/// A light is sampled in proportion to its power. The power of a textured light is its radiance
/// times the mean of its texels. A sixteenth of the probability is distributed evenly, because a
/// light of little power may be the only one that reaches some place.
Result<PreparedLights> prepare_lights(const diaphane::v1::Scene& scene, const CameraAxes& axes,
                                      const WorldToFrame& frame,
                                      const std::shared_ptr<const PreparedTextures>& before);

/// Returns the kernel features that these lights need.
Features features_of(const PreparedLights& lights);

}  // namespace diaphane::render
