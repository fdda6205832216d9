#pragma once

#include "renderd/kernel/features.h"
#include "renderd/kernel/lights.h"
#include "renderd/kernel/scatter.h"
#include "renderd/kernel/views.h"
#include "renderd/math/random.h"

// Next-event estimation: rays from a collision to the lights, before their transmittance. Which
// estimator goes on with them (tracked or exact transmittance) is not known here.

namespace diaphane::render {

/// A ray from a collision to a light. Its unbiased contribution to the path is `weight` times the
/// transmittance up to `distance`.
struct LightRay {
  Float3 direction;  ///< unit, mm
  float distance;    ///< mm; 3.4e38 to the environment
  Float3 weight;     ///< 0 where nothing can come: no need to trace it
  bool lit;
};

/// To one point of one of the lights of finite size. `place` in voxel indices.
template <Features F, typename Volume>
HOST_DEVICE LightRay area_light_ray(const SceneView<Volume>& scene, Float3 place,
                                    const Scatter<F>& scatter, Random::Pair u) {
  std::uint32_t which = 0;
  if constexpr (F.has(Feature::kManyLights)) which = pick_light(scene.lights, u.a);
  const LightSample light = sample_light(scene.lights.area[which], place * scene.spacing, u.a, u.b);
  if (!light.lit) return LightRay{{}, 0.0f, {}, false};
  return {light.direction, light.distance, light.irradiance * scatter.evaluate(light.direction),
          true};
}

/// Along one direction to the environment, drawn from how matter scatters.
template <Features F, typename Volume>
HOST_DEVICE LightRay environment_ray(const SceneView<Volume>& scene, Float3 place,
                                     const Scatter<F>& scatter, Random::Pair u) {
  (void)place;
  const ScatterSample s = scatter.sample(u.a, u.b);
  return {s.direction, 3.4e38f, scene.lights.environment * s.weight, s.density > 0.0f};
}

}  // namespace diaphane::render
