#pragma once

#include "renderd/kernel/features.h"
#include "renderd/kernel/light_texture.h"
#include "renderd/kernel/views.h"

// Environment lights with a texture. There may be several, each in its own frame.

namespace diaphane::render {

/// The sum over all maps in one direction.
struct MapsHit {
  Float3 radiance;
  float density;  ///< density of sample_maps(), per steradian
};
/// Returns the sum of the maps along `direction`, a unit vector in the volume's frame.
HOST_DEVICE MapsHit meet_maps(const LightsView& lights, Float3 direction) {
  MapsHit hit{};
  for (std::uint32_t i = 0; i < lights.map_count; ++i) {
    const EnvironmentMap& map = lights.maps[i];
    const LightTexture& texture = lights.textures[map.texture];
    const TexturePoint p =
        map_point(dot(direction, map.right), dot(direction, map.middle), dot(direction, map.up));
    hit.radiance += map.radiance * colour_at<TextureEdge::kWrapAcross>(lights, texture, p);
    hit.density += map.probability * map_density(lights, texture, p);
  }
  return hit;
}

/// Samples a unit direction in the volume's frame, roughly in proportion to the maps' radiance.
HOST_DEVICE Float3 sample_maps(const LightsView& lights, float u, float v) {
  const std::uint32_t i = first_above(
      lights.map_count, u, [&lights](std::uint32_t k) { return lights.maps[k].cumulative; });
  const EnvironmentMap& map = lights.maps[i];
  u = stretched(u, map.probability, map.cumulative);
  const Float3 d = sample_map(lights, lights.textures[map.texture], u, v);
  return map.right * d.x + map.middle * d.y + map.up * d.z;
}

/// Returns the radiance of a camera ray that leaves the volume. `direction` is a unit vector in mm,
/// and `off_centre` is CameraRay::off_centre.
template <Features F, typename Volume>
HOST_DEVICE Float3 escape_radiance(const SceneView<Volume>& scene, Float3 direction,
                                   float off_centre) {
  if constexpr (F.has(Feature::kTexturedEnvironment)) {
    if (scene.lights.maps_visible) {
      return scene.escape + meet_maps(scene.lights, direction).radiance;
    }
  }
  (void)direction;
  return scene.escape + scene.escape_edge * off_centre;
}

}  // namespace diaphane::render
