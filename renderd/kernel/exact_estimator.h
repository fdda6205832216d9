#pragma once

#include "renderd/kernel/exact.h"

namespace diaphane::render {

/// One sample of one pixel: its camera ray and its random numbers.
template <Features F, typename Volume>
struct CameraSample {
  CameraRay camera;
  PrimaryHit primary;
  Points points;
  Random random;

  HOST_DEVICE CameraSample(const SceneView<Volume>& scene, std::uint32_t x, std::uint32_t y,
                           std::uint64_t sample)
      : points(scene.stream, scene.pixel(x, y), scene.numbers.of(sample)),
        random(scene.seed, scene.pixel(x, y), scene.first_sample + scene.numbers.of(sample)) {
    const auto pair = [&](Points::Use use) {
      return scene.independent_points ? random.two() : points.pair(use);
    };
    const Random::Pair jitter = pair(Points::kPixel);
    Random::Pair lens{0.5f, 0.5f};
    if constexpr (F.has(Feature::kLens)) lens = pair(Points::kLens);
    camera = camera_ray<F>(scene, static_cast<float>(x) + jitter.a,
                           static_cast<float>(scene.first_row + y) + jitter.b, lens);
    primary = primary_hit<F>(scene, camera, shares_at<F>(scene, 0.0f));
  }
};

/// The work for a hit. Its light is `radiance` plus `weight` times the transmittance along a ray to
/// a light.
struct HitTask {
  Float3 radiance;  ///< emission and indirect light, which need no ray to a light
  Float3 weight;
  Ray ray;
  Span span;
  float ending;  ///< exponential variate for TransmittanceWalk
  bool lit;
};

/// Returns the task of stratum `stratum` of the hits of `kind`. `random` belongs to the sample.
/// Each stratum draws from its own stream, so that the order of the strata does not matter.
template <Features F, typename Volume>
HOST_DEVICE HitTask task_of(const SceneView<Volume>& scene, const CameraRay& camera,
                            const Points& points, const Random& random, int kind,
                            std::int32_t stratum, Hit hit) {
  Random own = random.fork(static_cast<std::uint32_t>(kind * kMostHits + stratum));
  const Random::Pair chance = own.unit_and_exponential();
  const Float3 place = camera.ray.at(hit.distance);
  const Scatter<F> scatter = scatter_at<F>(scene, place, hit.value, camera.direction, chance.a);
  const std::int32_t count = scene.exact.strata[kind];
  const float share = OpacityStratum(stratum, count).width;
  const auto pair = [&](Points::Use use) {
    if (scene.independent_points) return own.two();
    return points.pair(use, points.index() * static_cast<std::uint32_t>(count) +
                                static_cast<std::uint32_t>(stratum));
  };
  HitTask task{};
  if constexpr (F.has(Feature::kBounces)) {
    if (kind == kIndirect) {
      task.radiance =
          indirect_light<F>(scene, shares_at<F>(scene, 0.0f), place, scatter, own) * share;
      return task;
    }
  }
  if constexpr (F.has(Feature::kEmission)) {
    // The emission is the mean over all kinds but kIndirect, weighted by their numbers of strata.
    std::int32_t hits = 0;
    for (int k = 0; k < kIndirect; ++k) hits += scene.exact.strata[k];
    task.radiance = emission_at(scene.transfer, hit.value) *
                    (share * static_cast<float>(count) / static_cast<float>(hits));
  }
  const Strategy strategy = static_cast<Strategy>(kind);
  const LightRay light = light_ray<F>(scene, place, scatter, strategy, pair(points_of(strategy)));
  task.weight = light.weight * share;
  task.lit = light.lit;
  task.ray = {place, light.direction * scene.inverse_spacing};
  task.span =
      clip_span<F>(scene, task.ray, clip(task.ray, scene.grid.occupied, Span{0.0f, light.distance}),
                   RayKind::kLight);
  task.ending = chance.b;
  return task;
}

/// The stream of Random::fork() for the camera ray. No stratum of a hit uses this number.
inline constexpr std::uint32_t kCameraStream = 0xffffffu;

/// Returns the position in (0, 1) within the strata at which a sample places the hits of a kind.
/// `own` is forked for the camera ray. Callers must request the kinds in order.
template <Features F, typename Volume>
HOST_DEVICE float stratum_offset(const SceneView<Volume>& scene,
                                 const CameraSample<F, Volume>& sample, int kind, Random& own) {
  return scene.independent_points
             ? own.one()
             : sample.points.pair(Points::kDepth + static_cast<std::uint32_t>(kind)).a;
}

/// Walks the camera ray of one sample with find_hits(), which calls `mark` for each hit.
template <Features F, typename Volume, typename Target, typename Mark>
HOST_DEVICE FirstWalk walk_camera_ray(const SceneView<Volume>& scene,
                                      const CameraSample<F, Volume>& sample, Target&& target,
                                      float ending, Mark&& mark) {
  const Float3 b = sample.primary.background;
  const bool behind = b.x > 0.0f || b.y > 0.0f || b.z > 0.0f;
  return find_hits<F>(sample.camera.ray, sample.primary.span, scene.volume, scene.exact, target,
                      ending, behind, mark);
}

/// Returns one unbiased estimate of the radiance through pixel (x, y) by the exact walk. The first
/// collision and its light are exact; the path from there on (Feature::kBounces) uses tracking.
template <Features F, typename Volume>
HOST_DEVICE SampleOf<F> exact_estimate(const SceneView<Volume>& scene, std::uint32_t x,
                                       std::uint32_t y, std::uint64_t number) {
  const CameraSample<F, Volume> sample(scene, x, y, number);
  SampleOf<F> result{};
  result.radiance = sample.primary.background;
  result.hit_medium = result.shows_slice = sample.primary.slice;
  if constexpr (F.has(Feature::kGuides)) {
    if (number < kGuidedSamples) {
      result.guides = guides_along(scene, sample.camera.ray, sample.primary.span);
    }
  }
  if (!(sample.primary.span.begin < sample.primary.span.end)) return result;
  Float3 radiance{0.0f, 0.0f, 0.0f};
  Random own = sample.random.fork(kCameraStream);
  float offsets[kHitKinds] = {};
  constexpr KindList kKinds = hit_kinds<F>();
  for (int k = 0; k < kKinds.count; ++k) {
    offsets[kKinds.of[k]] = stratum_offset(scene, sample, kKinds.of[k], own);
  }
  const FirstWalk first = walk_camera_ray<F>(
      scene, sample,
      [&](const HitNumber& hit) {
        return target_depth(hit.stratum, scene.exact.strata[hit.kind], offsets[hit.kind]);
      },
      own.exponential(),
      [&](const HitNumber& which, const CellCrossing<Volume>& cell, float depth) {
        const Corners corners = scene.volume.corners(cell.cell, cell.brick);
        const float t =
            place_in_cell<F.has(Feature::kCurves)>(corners, cell.segment, scene.exact, depth);
        const Hit hit{t, corners.at(cell.segment.at(t))};
        const HitTask task = task_of<F>(scene, sample.camera, sample.points, sample.random,
                                        which.kind, which.stratum, hit);
        radiance += task.radiance;
        if (!task.lit) return;
        TransmittanceWalk<F, Volume> walk(task.ray, task.span, scene.volume, scene.exact,
                                          task.ending);
        CellCrossing<Volume> passed;
        while (!walk.ended()) walk.step(scene.volume, scene.exact, passed);
        radiance += task.weight * walk.transmittance();
      });
  result.hit_medium |= first.hit_medium;
  // A slice that adds less than half of 1/255 of white, in linear light, does not count as shown.
  result.shows_slice &= first.transmittance > 0.5f / 255.0f;
  result.radiance = radiance + sample.primary.background * first.transmittance;
  return result;
}

}  // namespace diaphane::render
