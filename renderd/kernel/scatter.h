#pragma once

#include "renderd/kernel/brdf.h"
#include "renderd/kernel/features.h"
#include "renderd/kernel/labels.h"
#include "renderd/kernel/medium.h"
#include "renderd/kernel/overlay.h"
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

/// Returns half the differences of the voxel values over two voxels along each axis.
template <typename Volume>
HOST_DEVICE Float3 voxel_differences(const Volume& volume, Float3 place) {
  const auto difference = [&](Float3 step) {
    return volume.at(place + step) - volume.at(place - step);
  };
  return Float3{difference({1.0f, 0.0f, 0.0f}), difference({0.0f, 1.0f, 0.0f}),
                difference({0.0f, 0.0f, 1.0f})} *
         0.5f;
}

/// Returns the gradient of the extinction, given that of the voxel values per mm.
HOST_DEVICE Gradient gradient_along(const TransferView& transfer, Float3 values, float value,
                                    float step) {
  const float steepness = length(values);
  if (!(steepness > 0.0f)) return {};
  const float change = extinction_at(transfer, value + step * steepness) -
                       extinction_at(transfer, value - step * steepness);
  return {values * (1.0f / steepness), fabsf(change) / (2.0f * step)};
}

/// Estimates the gradient at `place` (voxel indices), where the voxel value is `value`. The
/// direction is the gradient of the voxel values, from central differences over one voxel in each
/// direction, scaled to mm. Differences of the extinction would not do: the transfer function may
/// be a step, and they would point along the axes only. The slope is a central difference of the
/// extinction, at the values one edge of the smallest voxel away along the gradient in both
/// directions. A step is therefore detected at any place that its voxels influence.
///
/// With `second`, it is the gradient of the second scan, from its own voxels, at the same place of
/// the first scan.
template <Features F = Features{}, typename Volume>
HOST_DEVICE Gradient gradient_at(const SceneView<Volume>& scene, Float3 place, float value,
                                 [[maybe_unused]] bool second = false) {
  if constexpr (F.has(Feature::kOverlay)) {
    if (second) {
      const OverlayView<Volume>& o = scene.overlay;
      const Float3 there = voxel_differences(o.volume, in_second(o.map, place));
      const Float3 here =
          (o.map.rows[0] * there.x + o.map.rows[1] * there.y + o.map.rows[2] * there.z) *
          scene.inverse_spacing;
      return gradient_along(o.transfer, here, value, o.step);
    }
  }
  const float step = min(scene.spacing.x, min(scene.spacing.y, scene.spacing.z));
  return gradient_along(
      scene.transfer, voxel_differences(scene.volume, place) * scene.inverse_spacing, value, step);
}

/// Returns the transfer function of the scan that the matter belongs to.
template <Features F, typename Volume>
HOST_DEVICE const TransferView& transfer_of(const SceneView<Volume>& scene,
                                            [[maybe_unused]] bool second) {
  if constexpr (F.has(Feature::kOverlay)) {
    if (second) return scene.overlay.transfer;
  }
  return scene.transfer;
}

/// Returns how the matter at `place` (voxel indices) scatters. `value` is the voxel value there,
/// and `incoming` the unit direction (mm) of the ray that collided. `choice` in (0, 1) decides
/// between surface and phase function (Feature::kHybrid). `second`: the matter belongs to the
/// second scan, as `value` does (Feature::kOverlay). A scan scatters in the same way at any share
/// of it.
template <Features F, typename Volume>
HOST_DEVICE Scatter<F> scatter_at(const SceneView<Volume>& scene, Float3 place, float value,
                                  Float3 incoming, float choice, bool second = false) {
  const TransferView& transfer = transfer_of<F>(scene, second);
  Scatter<F> s{};
  s.albedo = albedo_at(transfer, value);
  [[maybe_unused]] float opacity = 1.0f;  // of the label
  if constexpr (F.has(Feature::kLabels)) {
    LabelLook look = kUnchangedLook;
    if (!second) look = look_at(scene.labels, scene.volume.size, place);
    s.albedo = albedo_of(scene, place, look, s.albedo);
    opacity = look.opacity;
  }
  s.incoming = incoming;
  s.g = scene.phase_g;
  if constexpr (F.has(Feature::kSurfaces)) {
    if (!(scene.surfaces > 0.0f)) return s;
    const Gradient gradient = gradient_at<F>(scene, place, value, second);
    s.surface = gradient.slope > 0.0f;
    if constexpr (F.has(Feature::kHybrid)) {
      // Where the scene shades only surfaces, `surfaces` is infinite and the exponential is 0.
      float surfaces = scene.surfaces;
      if constexpr (F.has(Feature::kOverlay)) surfaces = second ? scene.overlay.surfaces : surfaces;
      s.surface = s.surface && 1.0f - choice > expf(-gradient.slope * opacity * surfaces);
    }
    if (!s.surface) return s;
    // Both sides of a surface reflect.
    s.normal = gradient.direction * (dot(gradient.direction, incoming) > 0.0f ? -1.0f : 1.0f);
    if constexpr (F.has(Feature::kGloss)) {
      const Gloss gloss = gloss_at(transfer, value);
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
