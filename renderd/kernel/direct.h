#pragma once

#include "renderd/kernel/environment.h"
#include "renderd/kernel/features.h"
#include "renderd/kernel/lights.h"
#include "renderd/kernel/scatter.h"
#include "renderd/kernel/views.h"
#include "renderd/math/points.h"
#include "renderd/math/random.h"

// Next-event estimation: rays from a collision to the lights. The estimator computes their
// transmittance, by tracking or by the exact walk, and this code does not depend on which.
//
// Direct light is the sum of the estimates of the strategies below, each of which may have any
// number of samples. If two strategies can find the same light, `Mis` decides whether each counts
// only its share (multiple importance sampling by the power heuristic: Veach 1997, 9.2.4) or one of
// them counts fully.

namespace diaphane::render {

/// A ray from a collision to a light. Its unbiased contribution to the path is `weight` times the
/// transmittance up to `distance`.
struct LightRay {
  Float3 direction;  ///< unit, mm
  float distance;    ///< mm; 3.4e38 to the environment
  Float3 weight;     ///< 0 if no light can arrive, so that it need not be traced
  bool lit;
};

enum class Strategy : std::uint32_t {
  kAreaLight,           ///< a point on a light of finite size
  kAreaLightByScatter,  ///< a direction sampled from the scattering, which may meet such a light
  kEnvironment,         ///< a direction sampled from the scattering, to the environment
  kEnvironmentMap,      ///< a direction sampled from the environment's textures
};

/// Whether directions sampled from the scattering can find a light better than points sampled on
/// that light. The isotropic phase function cannot.
template <Features F>
inline constexpr bool kMixes = F.has(Feature::kAnisotropicPhase) || F.has(Feature::kSurfaces);

/// The strategies that a scene with these features needs, in the order of Strategy.
struct StrategyList {
  Strategy of[4];
  std::uint32_t count;
};
template <Features F>
HOST_DEVICE constexpr StrategyList strategies() {
  StrategyList list{};
  if (F.has(Feature::kAreaLights)) list.of[list.count++] = Strategy::kAreaLight;
  if (F.has(Feature::kAreaLights) && kMixes<F>) {
    list.of[list.count++] = Strategy::kAreaLightByScatter;
  }
  if (F.has(Feature::kEnvironment) || F.has(Feature::kTexturedEnvironment)) {
    list.of[list.count++] = Strategy::kEnvironment;
  }
  if (F.has(Feature::kTexturedEnvironment)) list.of[list.count++] = Strategy::kEnvironmentMap;
  return list;
}
template <Features F>
HOST_DEVICE constexpr std::uint32_t strategy_count() {
  return strategies<F>().count;
}
template <Features F>
HOST_DEVICE constexpr Strategy strategy_at(std::uint32_t i) {
  return strategies<F>().of[i];
}

/// Returns the pair of low-discrepancy points that a strategy uses.
HOST_DEVICE constexpr Points::Use points_of(Strategy strategy) {
  switch (strategy) {
    case Strategy::kAreaLight:
      return Points::kAreaLight;
    case Strategy::kAreaLightByScatter:
      return Points::kAreaLightByScatter;
    case Strategy::kEnvironment:
      return Points::kEnvironment;
    case Strategy::kEnvironmentMap:
      return Points::kEnvironmentMap;
  }
  return Points::kEnvironment;
}

/// Returns the weight of a sample whose technique has the density `density`, while the other
/// technique has `other`. The weights of both techniques for a direction add up to 1.
HOST_DEVICE float share(Mis mis, Mis own, float density, float other) {
  if (mis != Mis::kBoth) return mis == own ? 1.0f : 0.0f;
  const float ratio = other / density;
  return 1.0f / (1.0f + ratio * ratio);
}

HOST_DEVICE LightRay light_ray_of(Float3 direction, float distance, Float3 weight) {
  return {direction, distance, weight, weight.x + weight.y + weight.z > 0.0f};
}

/// Returns a ray to a point on one of the lights of finite size. `place` is in voxel indices.
template <Features F, typename Volume>
HOST_DEVICE LightRay area_light_ray(const SceneView<Volume>& scene, Float3 place,
                                    const Scatter<F>& scatter, Random::Pair u) {
  if (scene.lights.count == 0) return {};
  std::uint32_t which = 0;
  if constexpr (F.has(Feature::kManyLights)) which = pick_light(scene.lights, u.a);
  const LightSample light =
      sample_light<F>(scene.lights, scene.lights.area[which], place * scene.spacing, u.a, u.b);
  if (!light.lit) return {};
  Float3 weight = light.irradiance * scatter.evaluate(light.direction);
  if constexpr (kMixes<F>) {
    if (light.density < kDeltaDensity) {
      weight =
          weight * share(scene.mis, Mis::kLight, light.density, scatter.density(light.direction));
    }
  }
  return light_ray_of(light.direction, light.distance, weight);
}

/// Returns a ray in a direction sampled from the scattering, to a light of finite size if it meets
/// one.
template <Features F, typename Volume>
HOST_DEVICE LightRay area_light_ray_by_scatter(const SceneView<Volume>& scene, Float3 place,
                                               const Scatter<F>& scatter, Random::Pair u) {
  if (scene.mis == Mis::kLight || scene.lights.count == 0) return {};
  std::uint32_t which = 0;
  if constexpr (F.has(Feature::kManyLights)) which = pick_light(scene.lights, u.a);
  const AreaLight& light = scene.lights.area[which];
  const ScatterSample s = scatter.sample(u.a, u.b);
  if (!(s.density > 0.0f)) return {};
  const LightHit hit = meet_light<F>(scene.lights, light, place * scene.spacing, s.direction);
  if (!hit.met) return {};
  return light_ray_of(
      s.direction, hit.distance,
      hit.radiance * s.weight *
          (share(scene.mis, Mis::kScatter, s.density, hit.density) / light.probability));
}

/// The light of finite size that a ray meets; black if the ray meets none.
struct MetLight {
  Float3 radiance;  ///< divided by the probability of testing this light
  float distance;   ///< mm
};
/// Returns the light of finite size in a direction sampled from the scattering with the density
/// `density`. `u` chooses the light to test. A path that continues there needs no further ray.
template <Features F, typename Volume>
HOST_DEVICE MetLight area_light_by_scatter(const SceneView<Volume>& scene, Float3 place,
                                           Float3 direction, float density,
                                           [[maybe_unused]] float u) {
  if (scene.mis == Mis::kLight || scene.lights.count == 0) return {};
  std::uint32_t which = 0;
  if constexpr (F.has(Feature::kManyLights)) which = pick_light(scene.lights, u);
  const AreaLight& light = scene.lights.area[which];
  const LightHit hit = meet_light<F>(scene.lights, light, place * scene.spacing, direction);
  if (!hit.met) return {};
  return {
      hit.radiance * (share(scene.mis, Mis::kScatter, density, hit.density) / light.probability),
      hit.distance};
}

/// Returns the light of the environment in a direction sampled from the scattering with the density
/// `density`. Without kMixes, environment_map_ray() alone samples the textures, unless only
/// directions of the scattering are sampled (Mis::kScatter).
template <Features F, typename Volume>
HOST_DEVICE Float3 environment_by_scatter(const SceneView<Volume>& scene, Float3 direction,
                                          float density) {
  Float3 radiance = scene.lights.environment;
  if constexpr (F.has(Feature::kTexturedEnvironment)) {
    if (scene.mis == Mis::kScatter || (kMixes<F> && scene.mis == Mis::kBoth)) {
      const MapsHit maps = meet_maps(scene.lights, direction);
      radiance += maps.radiance * share(scene.mis, Mis::kScatter, density, maps.density);
    }
  }
  (void)direction;
  (void)density;
  return radiance;
}

/// Returns a ray to the environment in a direction sampled from the scattering.
template <Features F, typename Volume>
HOST_DEVICE LightRay environment_ray(const SceneView<Volume>& scene, Float3 place,
                                     const Scatter<F>& scatter, Random::Pair u) {
  (void)place;
  const ScatterSample s = scatter.sample(u.a, u.b);
  if (!(s.density > 0.0f)) return {};
  return light_ray_of(s.direction, 3.4e38f,
                      environment_by_scatter<F>(scene, s.direction, s.density) * s.weight);
}

/// Returns a ray in one direction sampled from the environment's textures.
template <Features F, typename Volume>
HOST_DEVICE LightRay environment_map_ray(const SceneView<Volume>& scene, const Scatter<F>& scatter,
                                         Random::Pair u) {
  if (scene.mis == Mis::kScatter || scene.lights.map_count == 0) return {};
  const Float3 direction = sample_maps(scene.lights, u.a, u.b);
  const MapsHit maps = meet_maps(scene.lights, direction);
  if (!(maps.density > 0.0f)) return {};
  Float3 weight = maps.radiance * scatter.evaluate(direction) * (1.0f / maps.density);
  if constexpr (kMixes<F>) {
    weight = weight * share(scene.mis, Mis::kLight, maps.density, scatter.density(direction));
  }
  return light_ray_of(direction, 3.4e38f, weight);
}

/// Returns one sample of one of strategies<F>().
template <Features F, typename Volume>
HOST_DEVICE LightRay light_ray(const SceneView<Volume>& scene, Float3 place,
                               const Scatter<F>& scatter, Strategy strategy, Random::Pair u) {
  if constexpr (F.has(Feature::kAreaLights)) {
    if (strategy == Strategy::kAreaLight) return area_light_ray(scene, place, scatter, u);
    if constexpr (kMixes<F>) {
      if (strategy == Strategy::kAreaLightByScatter) {
        return area_light_ray_by_scatter(scene, place, scatter, u);
      }
    }
  }
  if constexpr (F.has(Feature::kTexturedEnvironment)) {
    if (strategy == Strategy::kEnvironmentMap) return environment_map_ray(scene, scatter, u);
  }
  if constexpr (F.has(Feature::kEnvironment) || F.has(Feature::kTexturedEnvironment)) {
    if (strategy == Strategy::kEnvironment) return environment_ray(scene, place, scatter, u);
  }
  return {};
}

/// Returns whether a strategy can find any light in this scene. If not, it needs no samples.
template <Features F, typename Volume>
HOST_DEVICE bool is_of_use(const SceneView<Volume>& scene, Strategy strategy) {
  const LightsView& lights = scene.lights;
  switch (strategy) {
    case Strategy::kAreaLight:
      // This does not depend on `mis`, because no other strategy finds a point light.
      return lights.count > 0;
    case Strategy::kAreaLightByScatter:
      return lights.count > 0 && scene.mis != Mis::kLight;
    case Strategy::kEnvironment:
      if (lights.environment.x + lights.environment.y + lights.environment.z > 0.0f) return true;
      return lights.map_count > 0 &&
             (scene.mis == Mis::kScatter || (kMixes<F> && scene.mis == Mis::kBoth));
    case Strategy::kEnvironmentMap:
      return lights.map_count > 0 && scene.mis != Mis::kScatter;
  }
  return false;
}

}  // namespace diaphane::render
