#pragma once

#include "renderd/kernel/features.h"
#include "renderd/kernel/lights.h"
#include "renderd/kernel/medium.h"
#include "renderd/kernel/phase.h"
#include "renderd/kernel/tracking.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"
#include "renderd/math/random.h"

namespace diaphane::render {

/// One estimate of one pixel's radiance.
struct Sample {
  Float3 radiance;
  bool met_matter;  ///< the camera ray met contents of the volume (the error counts such pixels
                    ///< only)
};

/// A camera ray: in voxel indices for tracking, its unit direction in mm for the phase function.
struct CameraRay {
  Ray ray;
  Float3 direction;
};

/// Through the point (x, y) of the picture, in pixels from its upper left corner.
template <typename Volume>
HOST_DEVICE CameraRay camera_ray(const SceneView<Volume>& scene, float x, float y) {
  const CameraView& c = scene.camera;
  const float a = 2.0f * x / static_cast<float>(scene.width) - 1.0f;
  const float b = 1.0f - 2.0f * y / static_cast<float>(scene.height);
  const Float3 aside = c.right * a + c.up * b;
  CameraRay r;
  r.direction = normalize(c.forward + aside);
  r.ray.origin = (c.start + aside * c.near) * scene.inverse_spacing;
  r.ray.direction = r.direction * scene.inverse_spacing;
  return r;
}

/// Transmittance from `place` (voxel indices) along the unit `direction` (mm) for `distance` mm.
template <Features F, typename Volume>
HOST_DEVICE float visibility(const SceneView<Volume>& scene, Float3 place, Float3 direction,
                             float distance, Random& random) {
  const Ray ray{place, direction * scene.inverse_spacing};
  const Span span = clip(ray, scene.grid.occupied, Span{0.0f, distance});
  if (!(span.begin < span.end)) return 1.0f;
  return transmittance<F.has(Feature::kSteepExtinction)>(
      ray, span, scene.grid, Medium<Volume>{scene.volume, scene.transfer}, random);
}

/// Light that reaches `place` and is scattered towards the camera, over the albedo: next-event
/// estimation to one point of one rectangle and along one direction to the environment (drawn from
/// the phase function itself).
template <Features F, typename Volume>
HOST_DEVICE Float3 direct_light(const SceneView<Volume>& scene, Float3 place, Float3 direction,
                                Random& random) {
  Float3 sum{0.0f, 0.0f, 0.0f};
  if constexpr (F.has(Feature::kRectangles)) {
    Random::Pair u = random.two();
    std::uint32_t which = 0;
    if constexpr (F.has(Feature::kManyRectangles)) which = pick_rectangle(scene.lights, u.a);
    const LightSample light =
        sample_rectangle(scene.lights.rectangles[which], place * scene.spacing, u.a, u.b);
    if (light.lit) {
      float phase = kIsotropicPhase;
      if constexpr (F.has(Feature::kAnisotropicPhase)) {
        phase = henyey_greenstein(scene.phase_g, direction, light.direction);
      }
      const float seen = visibility<F>(scene, place, light.direction, light.distance, random);
      sum += light.irradiance * (phase * seen);
    }
  }
  if constexpr (F.has(Feature::kEnvironment)) {
    const Random::Pair u = random.two();
    Float3 towards;
    if constexpr (F.has(Feature::kAnisotropicPhase)) {
      towards = sample_henyey_greenstein(scene.phase_g, direction, u.a, u.b);
    } else {
      towards = sample_sphere(u.a, u.b);
    }
    sum += scene.lights.environment * visibility<F>(scene, place, towards, 3.4e38f, random);
  }
  return sum;
}

/// One unbiased estimate of the radiance through pixel (x, y) with single scattering: number
/// `sample` of the picture's stream. The pixel is a box filter.
template <Features F, typename Volume>
HOST_DEVICE Sample estimate(const SceneView<Volume>& scene, std::uint32_t x, std::uint32_t y,
                            std::uint64_t sample) {
  Random random(scene.seed, x + scene.width * y, sample);
  const Random::Pair jitter = random.two();
  const CameraRay camera =
      camera_ray(scene, static_cast<float>(x) + jitter.a, static_cast<float>(y) + jitter.b);
  Sample result{scene.escape, false};
  const Span span = clip(camera.ray, scene.grid.occupied, Span{0.0f, 3.4e38f});
  if (!(span.begin < span.end)) return result;
  const Collision hit = track<F.has(Feature::kSteepExtinction)>(
      camera.ray, span, scene.grid, Medium<Volume>{scene.volume, scene.transfer}, random);
  result.met_matter = hit.met_matter;
  if (!hit.found) return result;
  result.radiance = albedo_at(scene.transfer, hit.value) *
                    direct_light<F>(scene, camera.ray.at(hit.distance), camera.direction, random);
  return result;
}

}  // namespace diaphane::render
