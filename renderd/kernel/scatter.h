#pragma once

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
/// than these three functions.
template <Features F>
struct Scatter {
  Float3 albedo;
  Float3 incoming;  ///< unit, mm: the direction in which the path came
  float g;          ///< Henyey-Greenstein

  /// Radiance scattered along the path per irradiance from the unit direction `to`: albedo times
  /// phase function, or the BRDF times the cosine; per steradian.
  HOST_DEVICE Float3 evaluate(Float3 to) const { return albedo * density(to); }

  HOST_DEVICE ScatterSample sample(float u, float v) const {
    ScatterSample s;
    if constexpr (F.has(Feature::kAnisotropicPhase)) {
      s.direction = sample_henyey_greenstein(g, incoming, u, v);
    } else {
      s.direction = sample_sphere(u, v);
    }
    s.density = density(s.direction);
    s.weight = albedo;
    return s;
  }

  /// Of sample() in the direction `to`, per steradian.
  HOST_DEVICE float density(Float3 to) const {
    if constexpr (F.has(Feature::kAnisotropicPhase)) return henyey_greenstein(g, incoming, to);
    return kIsotropicPhase;
  }
};

/// `place` in voxel indices, `value` the voxel value there, `incoming` the unit direction (mm) of
/// the ray that collided, `choice` in (0, 1) chooses where there are two ways to scatter.
template <Features F, typename Volume>
HOST_DEVICE Scatter<F> scatter_at(const SceneView<Volume>& scene, Float3 place, float value,
                                  Float3 incoming, float choice) {
  (void)place;
  (void)choice;
  return {albedo_at(scene.transfer, value), incoming, scene.phase_g};
}

}  // namespace diaphane::render
