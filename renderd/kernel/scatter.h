#pragma once

#include "renderd/kernel/brdf.h"
#include "renderd/kernel/features.h"
#include "renderd/kernel/labels.h"
#include "renderd/kernel/medium.h"
#include "renderd/kernel/phase.h"
#include "renderd/kernel/views.h"

namespace diaphane::render {

/// A direction sampled from a scattering distribution.
struct ScatterSample {
  Float3 direction;  ///< unit vector in mm space, in which the path continues
  Float3 weight;     ///< factor of the path's weight, evaluate() over density(); 0 ends the path
  float density;     ///< per steradian
};

/// How the matter at one collision scatters light. The estimators use only evaluate(), sample() and
/// density(), which depend on nothing but the members and their arguments.
template <Features F>
struct Scatter {
  static constexpr bool kLobe = F.has(Feature::kGloss);

  Float3 albedo;
  Float3 incoming;  ///< unit, mm: the direction of the incoming path
  float g;          ///< parameter of the Henyey-Greenstein phase function
  /// Whether the collision is at a surface (kSurfaces only). Only then are the members below valid.
  bool surface;
  Float3 normal;  ///< unit, mm, on the side of the incoming path
  Float3 specular;
  float roughness;

  HOST_DEVICE Brdf brdf() const { return {normal, incoming * -1.0f, albedo, specular, roughness}; }

  /// Returns the radiance scattered along the path per irradiance from the unit direction `to`, per
  /// steradian: albedo times phase function, or the BRDF times the cosine.
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

  /// Returns the density of sample() in the direction `to`, per steradian.
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

/// The gradient of the extinction at a place.
struct Gradient {
  Float3 direction;  ///< unit, mm; the sign is arbitrary
  float slope;  ///< of the extinction along it, per mm^2; 0: no gradient and no valid direction
};

/// Estimates the gradient at `place` (voxel indices), where the voxel value is `value`. The
/// direction is the gradient of the voxel values, from central differences over one voxel in each
/// direction, scaled to mm. Differences of the extinction would not do: the transfer function may
/// be a step, and they would point along the axes only. The slope is a central difference of the
/// extinction, at the values one edge of the smallest voxel away along the gradient in both
/// directions. A step is therefore detected at any place that its voxels influence.
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
  const float step = min(scene.spacing.x, min(scene.spacing.y, scene.spacing.z));
  const float change = extinction_at(scene.transfer, value + step * steepness) -
                       extinction_at(scene.transfer, value - step * steepness);
  return {values * (1.0f / steepness), fabsf(change) / (2.0f * step)};
}

/// Returns how the matter at `place` (voxel indices) scatters. `value` is the voxel value there,
/// and `incoming` the unit direction (mm) of the ray that collided. `choice` in (0, 1) decides
/// between surface and phase function (Feature::kHybrid).
template <Features F, typename Volume>
HOST_DEVICE Scatter<F> scatter_at(const SceneView<Volume>& scene, Float3 place, float value,
                                  Float3 incoming, float choice) {
  Scatter<F> s{};
  s.albedo = albedo_at(scene.transfer, value);
  [[maybe_unused]] float opacity = 1.0f;  // of the label
  if constexpr (F.has(Feature::kLabels)) {
    const LabelLook look = look_at(scene.labels, scene.volume.size, place);
    s.albedo = albedo_of(scene, place, look, s.albedo);
    opacity = look.opacity;
  }
  s.incoming = incoming;
  s.g = scene.phase_g;
  if constexpr (F.has(Feature::kSurfaces)) {
    if (!(scene.surfaces > 0.0f)) return s;
    const Gradient gradient = gradient_at(scene, place, value);
    s.surface = gradient.slope > 0.0f;
    if constexpr (F.has(Feature::kHybrid)) {
      // Where the scene shades only surfaces, `surfaces` is infinite and the exponential is 0.
      s.surface = s.surface && 1.0f - choice > expf(-gradient.slope * opacity * scene.surfaces);
    }
    if (!s.surface) return s;
    // Both sides of a surface reflect.
    s.normal = gradient.direction * (dot(gradient.direction, incoming) > 0.0f ? -1.0f : 1.0f);
    if constexpr (F.has(Feature::kGloss)) {
      const Gloss gloss = gloss_at(scene.transfer, value);
      s.specular = gloss.specular;
      s.roughness = max((1.0f - gloss.gloss) * (1.0f - gloss.gloss), kLeastRoughness);
    }
  } else {
    (void)place;
    (void)choice;
  }
  return s;
}

}  // namespace diaphane::render
