#pragma once

#include "renderd/kernel/camera.h"
#include "renderd/kernel/clip.h"
#include "renderd/kernel/direct.h"
#include "renderd/kernel/features.h"
#include "renderd/kernel/guides.h"
#include "renderd/kernel/primary.h"
#include "renderd/kernel/scatter.h"
#include "renderd/kernel/tracking.h"
#include "renderd/kernel/views.h"
#include "renderd/kernel/walk.h"
#include "renderd/math/points.h"
#include "renderd/math/random.h"

namespace diaphane::render {

/// One estimate of one pixel's radiance.
struct Sample {
  Float3 radiance;
  /// Whether the camera ray met matter or a slice. Only such pixels count for the error.
  bool hit_medium;
  bool shows_slice = false;  ///< whether the pixel shows a slice, which is never denoised
};
/// A sample of a kernel with Feature::kGuides.
struct GuidedSample : Sample {
  Guides guides;  ///< set for the film's first kGuidedSamples, otherwise zero
};
template <bool Guided>
struct SampleChoice {
  using Type = Sample;
};
template <>
struct SampleChoice<true> {
  using Type = GuidedSample;
};
template <Features F>
using SampleOf = typename SampleChoice<F.has(Feature::kGuides)>::Type;

/// Returns the transmittance from `place` (voxel indices) along the unit `direction` (mm) for
/// `distance` mm, estimated by tracking.
template <Features F, typename Volume>
HOST_DEVICE float tracked_visibility(const SceneView<Volume>& scene, SharesOf<F> shares,
                                     Float3 place, Float3 direction, float distance,
                                     Random& random) {
  const Ray ray{place, direction * scene.inverse_spacing};
  const Span span = clip_span<F>(scene, ray, clip(ray, scene.grid.occupied, Span{0.0f, distance}),
                                 RayKind::kLight);
  if (!(span.begin < span.end)) return 1.0f;
  return transmittance<F.has(Feature::kSteepExtinction)>(ray, span, scene.grid,
                                                         medium_of<F>(scene, shares), random);
}

/// Number of collisions after which a path may end by roulette. Before, roulette adds more noise
/// than the time it saves is worth.
inline constexpr std::uint32_t kFirstRoulette = 3;

/// Returns the indirect light that the first collision of a path, at `place` (voxel indices),
/// scatters along the path. This is an unbiased estimate of all light from second and later
/// collisions, including their own emission. Light that reaches the first collision directly from
/// the lights is not included.
///
/// At each collision, rays go to points of the lights and of the environment's textures. Strategies
/// that sample directions of the scattering need no rays of their own, because the path itself
/// continues in such a direction.
template <Features F, typename Volume>
HOST_DEVICE Float3 indirect_light(const SceneView<Volume>& scene, SharesOf<F> shares, Float3 place,
                                  Scatter<F> scatter, Random& random) {
  Float3 radiance{0.0f, 0.0f, 0.0f}, weight{1.0f, 1.0f, 1.0f};
  if (scene.bounces < 2) return radiance;
  for (std::uint32_t collisions = 1;; ++collisions) {
    const Random::Pair u = random.two();
    const ScatterSample next = scatter.sample(u.a, u.b);
    weight = weight * next.weight;
    float left = max_component(weight);
    if (!(left > 0.0f)) return radiance;
    if (scene.roulette && collisions >= kFirstRoulette && left < 1.0f) {
      if (random.one() >= left) return radiance;
      weight = weight * (1.0f / left);
    }
    const Ray ray{place, next.direction * scene.inverse_spacing};
    const Span span = clip_span<F>(scene, ray, clip(ray, scene.grid.occupied, Span{0.0f, 3.4e38f}),
                                   RayKind::kLight);
    Collision hit{0.0f, 0.0f, false, false};
    if (span.begin < span.end) {
      hit = track<F.has(Feature::kSteepExtinction)>(ray, span, scene.grid,
                                                    medium_of<F>(scene, shares), random);
    }
    if constexpr (F.has(Feature::kAreaLights) && kMixes<F>) {
      if (collisions > 1) {
        const MetLight met =
            area_light_by_scatter<F>(scene, place, next.direction, next.density, random.one());
        if (!hit.found || hit.distance > met.distance) radiance += weight * met.radiance;
      }
    }
    if (!hit.found) {
      if constexpr (F.has(Feature::kEnvironment) || F.has(Feature::kTexturedEnvironment)) {
        if (collisions > 1) {
          radiance += weight * environment_by_scatter<F>(scene, next.direction, next.density);
        }
      }
      return radiance;
    }
    if (collisions == scene.bounces) return radiance;
    place = ray.at(hit.distance);
    float choice = 0.5f;
    if constexpr (F.has(Feature::kHybrid)) choice = random.one();
    scatter = scatter_at<F>(scene, place, hit.value, next.direction, choice, hit.second);
    if constexpr (F.has(Feature::kEmission)) {
      radiance += weight * emission_at(transfer_of<F>(scene, hit.second), hit.value);
    }
    for (std::uint32_t i = 0; i < strategy_count<F>(); ++i) {
      const Strategy strategy = strategy_at<F>(i);
      if (strategy == Strategy::kEnvironment || strategy == Strategy::kAreaLightByScatter ||
          !is_of_use<F>(scene, strategy)) {
        continue;
      }
      const LightRay light = light_ray<F>(scene, place, scatter, strategy, random.two());
      if (light.lit) {
        radiance +=
            weight * light.weight *
            tracked_visibility<F>(scene, shares, place, light.direction, light.distance, random);
      }
    }
  }
}

/// Returns one unbiased estimate of the radiance through the film's pixel (x, y) by tracking.
/// `sample` counts the samples of the film, from 0. The pixel filter is a box.
template <Features F, typename Volume>
HOST_DEVICE SampleOf<F> estimate(const SceneView<Volume>& scene, std::uint32_t x, std::uint32_t y,
                                 std::uint64_t sample) {
  const std::uint32_t pixel = scene.pixel(x, y);
  const std::uint64_t number = scene.numbers.of(sample);
  Random random(scene.seed, pixel, scene.first_sample + number);
  const Points points(scene.stream, pixel, number);
  const auto pair = [&](Points::Use use) {
    return scene.independent_points ? random.two() : points.pair(use);
  };
  const Random::Pair jitter = pair(Points::kPixel);
  Random::Pair lens{0.5f, 0.5f};
  if constexpr (F.has(Feature::kLens)) lens = pair(Points::kLens);
  const CameraRay camera = camera_ray<F>(scene, static_cast<float>(x) + jitter.a,
                                         static_cast<float>(scene.first_row + y) + jitter.b, lens);
  const SharesOf<F> shares = shares_at<F>(scene, static_cast<float>(x) + jitter.a);
  const PrimaryHit primary = primary_hit<F>(scene, camera, shares);
  const Span span = primary.span;
  SampleOf<F> result{};
  result.radiance = primary.background;
  result.hit_medium = result.shows_slice = primary.slice;
  if constexpr (F.has(Feature::kGuides)) {
    if (sample < kGuidedSamples) result.guides = guides_along<F>(scene, camera.ray, span, shares);
  }
  if (!(span.begin < span.end)) return result;
  const Collision hit = track<F.has(Feature::kSteepExtinction)>(
      camera.ray, span, scene.grid, medium_of<F>(scene, shares), random);
  result.hit_medium |= hit.hit_medium;
  if (!hit.found) return result;
  result.shows_slice = false;
  const Float3 place = camera.ray.at(hit.distance);
  float choice = 0.5f;
  if constexpr (F.has(Feature::kHybrid)) choice = pair(Points::kPick).a;
  const Scatter<F> scatter =
      scatter_at<F>(scene, place, hit.value, camera.direction, choice, hit.second);
  result.radiance = {0.0f, 0.0f, 0.0f};
  if constexpr (F.has(Feature::kEmission)) {
    result.radiance = emission_at(transfer_of<F>(scene, hit.second), hit.value);
  }
  const auto add = [&](const LightRay& light) {
    if (!light.lit) return;
    const float visibility =
        tracked_visibility<F>(scene, shares, place, light.direction, light.distance, random);
    result.radiance += light.weight * visibility;
  };
  for (std::uint32_t i = 0; i < strategy_count<F>(); ++i) {
    const Strategy strategy = strategy_at<F>(i);
    if (is_of_use<F>(scene, strategy)) {
      add(light_ray<F>(scene, place, scatter, strategy, pair(points_of(strategy))));
    }
  }
  if constexpr (F.has(Feature::kBounces)) {
    result.radiance += indirect_light<F>(scene, shares, place, scatter, random);
  }
  return result;
}

}  // namespace diaphane::render
