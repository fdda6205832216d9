#pragma once

#include "renderd/kernel/brdf.h"
#include "renderd/kernel/features.h"
#include "renderd/kernel/medium.h"
#include "renderd/kernel/phase.h"
#include "renderd/kernel/views.h"

namespace diaphane::render {

/// A direction drawn from a scattering distribution.
struct ScatterSample {
  Float3 direction;  ///< unit, mm, in which the path goes on
  Float3 weight;  ///< evaluate() over density(): what it multiplies the path by; 0: the path ends
  float density;  ///< per steradian
};

/// How the matter at one collision scatters light. Pure; the engine's estimators know no more of it
/// than these three functions. Members that no feature in `F` needs are not in the code.
template <Features F>
struct Scatter {
  static constexpr bool kLobe = F.has(Feature::kGloss);

  Float3 albedo;
  Float3 incoming;  ///< unit, mm: the direction in which the path came
  float g;          ///< Henyey-Greenstein
  bool surface;     ///< it is one here (kSurfaces only), and then:
  Float3 normal;    ///< unit, mm, turned to where the path came from
  Float3 specular;
  float roughness;

  HOST_DEVICE Brdf brdf() const { return {normal, incoming * -1.0f, albedo, specular, roughness}; }

  /// Radiance scattered along the path per irradiance from the unit direction `to`: albedo times
  /// phase function, or the BRDF times the cosine; per steradian.
  HOST_DEVICE Float3 evaluate(Float3 to) const {
    if constexpr (F.has(Feature::kSurfaces)) {
      if (surface) return evaluate_brdf<kLobe>(brdf(), to);
    }
    return albedo * phase_density(to);
  }

  HOST_DEVICE ScatterSample sample(float u, float v) const {
    ScatterSample s;
    if constexpr (F.has(Feature::kSurfaces)) {
      if (surface) {
        const Brdf b = brdf();
        s.direction = sample_brdf<kLobe>(b, u, v);
        s.density = brdf_density<kLobe>(b, s.direction);
        s.weight = {0.0f, 0.0f, 0.0f};
        if (s.density > 0.0f) {
          s.weight = kLobe ? evaluate_brdf<kLobe>(b, s.direction) * (1.0f / s.density) : albedo;
        }
        return s;
      }
    }
    if constexpr (F.has(Feature::kAnisotropicPhase)) {
      s.direction = sample_henyey_greenstein(g, incoming, u, v);
    } else {
      s.direction = sample_sphere(u, v);
    }
    s.density = phase_density(s.direction);
    s.weight = albedo;
    return s;
  }

  /// Of sample() in the direction `to`, per steradian.
  HOST_DEVICE float density(Float3 to) const {
    if constexpr (F.has(Feature::kSurfaces)) {
      if (surface) return brdf_density<kLobe>(brdf(), to);
    }
    return phase_density(to);
  }

  HOST_DEVICE float phase_density(Float3 to) const {
    if constexpr (F.has(Feature::kAnisotropicPhase)) return henyey_greenstein(g, incoming, to);
    return kIsotropicPhase;
  }
};

/// How the extinction changes around a place.
struct Gradient {
  Float3 direction;  ///< unit, mm; its sign means nothing
  float slope;       ///< of the extinction along it, per mm^2; 0: no gradient, and no direction
};

/// The direction is that of the voxel values, by central differences one voxel each way in world
/// lengths: the function after them may be a step, whose own differences would point along the axes
/// only. The slope is a central difference too, of the function over the values met one smallest
/// voxel either way along the gradient, so that a step is seen from as far as its voxels reach.
/// `place` in voxel indices, `value` there.
template <typename Volume>
HOST_DEVICE Gradient gradient_at(const SceneView<Volume>& scene, Float3 place, float value) {
  const auto difference = [&](Float3 step) {
    return scene.volume.at(place + step) - scene.volume.at(place - step);
  };
  const Float3 values = Float3{difference({1.0f, 0.0f, 0.0f}), difference({0.0f, 1.0f, 0.0f}),
                               difference({0.0f, 0.0f, 1.0f})} *
                        scene.inverse_spacing * 0.5f;
  const float steepness = length(values);
  if (!(steepness > 0.0f)) return {};
  const float step = smaller(scene.spacing.x, smaller(scene.spacing.y, scene.spacing.z));
  const float change = extinction_at(scene.transfer, value + step * steepness) -
                       extinction_at(scene.transfer, value - step * steepness);
  return {values * (1.0f / steepness), fabsf(change) / (2.0f * step)};
}

/// `place` in voxel indices, `value` the voxel value there, `incoming` the unit direction (mm) of
/// the ray that collided, `choice` in (0, 1) chooses where there are two ways to scatter.
template <Features F, typename Volume>
HOST_DEVICE Scatter<F> scatter_at(const SceneView<Volume>& scene, Float3 place, float value,
                                  Float3 incoming, float choice) {
  Scatter<F> s{};
  s.albedo = albedo_at(scene.transfer, value);
  s.incoming = incoming;
  s.g = scene.phase_g;
  if constexpr (F.has(Feature::kSurfaces)) {
    if (!(scene.surfaces > 0.0f)) return s;
    const Gradient gradient = gradient_at(scene, place, value);
    s.surface = gradient.slope > 0.0f;
    if constexpr (F.has(Feature::kHybrid)) {
      // `surfaces` is infinite without the choice: nothing is left of the other way.
      s.surface = s.surface && 1.0f - choice > expf(-gradient.slope * scene.surfaces);
    }
    if (!s.surface) return s;
    // Both sides of a surface reflect.
    s.normal = gradient.direction * (dot(gradient.direction, incoming) > 0.0f ? -1.0f : 1.0f);
    if constexpr (F.has(Feature::kGloss)) {
      const Gloss gloss = gloss_at(scene.transfer, value);
      s.specular = gloss.specular;
      s.roughness = larger((1.0f - gloss.gloss) * (1.0f - gloss.gloss), kLeastRoughness);
    }
  } else {
    (void)place;
    (void)choice;
  }
  return s;
}

}  // namespace diaphane::render
