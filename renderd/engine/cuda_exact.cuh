#pragma once

#include "renderd/engine/cuda_trace.cuh"
#include "renderd/kernel/exact_estimator.h"

// The exact walk, for nvcc (ahead of time) and for NVRTC. A warp takes 8 x 4 pixels. Each lane
// walks the camera ray of its own; the hits of all wait in shared memory, and the lanes take them
// from there, whoever is free the next: a shadow ray ends after 3 cells or after 300, and a lane
// that waited for the longest of its warp would idle most of the time.

namespace diaphane::render::cuda {

/// Blocks that fit on a multiprocessor: caps the registers.
#if !defined(DIAPHANE_EXACT_BLOCKS)
#define DIAPHANE_EXACT_BLOCKS 6
#endif
/// So many lanes must be free before they take new hits together: starting a ray costs as much as
/// some ten cells, and lanes that start at different times would each make the others wait for it.
#if !defined(DIAPHANE_EXACT_REFILL)
#define DIAPHANE_EXACT_REFILL 8
#endif
/// Cells between two looks at who is free.
#if !defined(DIAPHANE_EXACT_STEPS)
#define DIAPHANE_EXACT_STEPS 4
#endif

/// What waits in shared memory, an array of 32 lanes for each stratum: first the hit, then its
/// light.
struct HitSlots {
  float* x;  ///< distance (negative: no hit), then red
  float* y;  ///< value, then green
  float* z;  ///< then blue

  __device__ __forceinline__ HitSlots(float* memory, int strata)
      : x(memory), y(memory + 32 * strata), z(memory + 64 * strata) {}
  __device__ __forceinline__ void put(int slot, Float3 c) const {
    x[slot] = c.x;
    y[slot] = c.y;
    z[slot] = c.z;
  }
  __device__ __forceinline__ Float3 at(int slot) const { return {x[slot], y[slot], z[slot]}; }
};

/// The camera rays of a warp's pixels, an array of 32 for each number.
__device__ __forceinline__ void put_ray(float* rays, int lane, const Ray& ray) {
  const float numbers[6] = {ray.origin.x,    ray.origin.y,    ray.origin.z,
                            ray.direction.x, ray.direction.y, ray.direction.z};
  for (int i = 0; i < 6; ++i) rays[32 * i + lane] = numbers[i];
}
__device__ __forceinline__ Ray get_ray(const float* rays, int lane) {
  return {{rays[lane], rays[32 + lane], rays[64 + lane]},
          {rays[96 + lane], rays[128 + lane], rays[160 + lane]}};
}

/// Where a kind's strata begin among all.
HOST_DEVICE std::int32_t begin_of(const ExactView& exact, int kind) {
  std::int32_t begin = 0;
  for (int k = 0; k < kind; ++k) begin += exact.strata[k];
  return begin;
}

/// Floats of shared memory a warp needs.
HOST_DEVICE std::uint32_t exact_floats(std::uint32_t strata) { return 32 * (3 * strata + 6); }

/// The light of all hits of a warp's pixels, from slots of hits to slots of colours.
template <Features F>
__device__ __forceinline__ void light_hits(const SceneView<TextureVolume>& scene, std::uint32_t x0,
                                           std::uint32_t y0, std::uint64_t number, int strata,
                                           const HitSlots& slots, const float* rays) {
  const std::uint32_t lane = threadIdx.x & 31;
  const int total = 32 * strata;
  int next = 0;
  bool active = false;
  int slot = 0;
  Float3 weight{}, radiance{};
  TransmittanceWalk walk;
  for (;;) {
    const std::uint32_t idle = __ballot_sync(~0u, !active);
    const int free = __popc(idle);
    if (next < total ? free >= DIAPHANE_EXACT_REFILL : free == 32) {
      if (next >= total) return;
      const int mine = next + __popc(idle & ((1u << lane) - 1u));
      next += free;
      if (!active && mine < total) {
        slot = mine;
        const Hit hit{slots.x[slot], slots.y[slot]};
        if (hit.distance >= 0.0f) {
          const int pixel = slot & 31, stratum = slot >> 5;
          CameraRay camera;
          camera.ray = get_ray(rays, pixel);
          camera.direction = camera.ray.direction * scene.spacing;
          const std::uint32_t index = x0 + (pixel & 7) + scene.width * (y0 + (pixel >> 3));
          const Points points(scene.stream, index, number);
          const Random random(scene.seed, index, scene.first_sample + number);
          int kind = 0, first = 0;
          while (stratum >= first + scene.exact.strata[kind]) first += scene.exact.strata[kind++];
          const HitTask task =
              task_of<F>(scene, camera, points, random, kind, stratum - first, hit);
          if (task.lit) {
            active = true;
            weight = task.weight;
            radiance = task.radiance;
            walk = TransmittanceWalk(task.ray, task.span, scene.exact, task.ending);
          } else {
            slots.put(slot, task.radiance);
          }
        } else {
          slots.put(slot, Float3{0.0f, 0.0f, 0.0f});
        }
      }
      continue;
    }
    if (active) {
#pragma unroll 1
      for (int i = 0; i < DIAPHANE_EXACT_STEPS; ++i) {
        if (!walk.step(scene.volume, scene.exact)) {
          slots.put(slot, radiance + weight * walk.transmittance());
          active = false;
          break;
        }
      }
    }
    __syncwarp();
  }
}

template <std::uint32_t Bits>
__global__ void __launch_bounds__(kTraceBlock, DIAPHANE_EXACT_BLOCKS)
    exact_kernel(const __grid_constant__ SceneView<TextureVolume> scene,
                 const __grid_constant__ Stripe stripe,
                 const __grid_constant__ TraceTarget target) {
  constexpr Features kF{Bits};
  extern __shared__ float shared[];
  const int strata = begin_of(scene.exact, kHitKinds);
  const std::uint32_t warp = threadIdx.x >> 5, lane = threadIdx.x & 31;
  float* rays = shared + warp * exact_floats(static_cast<std::uint32_t>(strata));
  const HitSlots slots(rays + 6 * 32, strata);
  // A block is 16 x 8 pixels, a warp 8 x 4 of them.
  const std::uint32_t x0 = blockIdx.x * 16 + (warp & 1) * 8;
  const std::uint32_t y0 = stripe.first_row + blockIdx.y * 8 + (warp >> 1) * 4;
  const std::uint32_t x = x0 + (lane & 7), y = y0 + (lane >> 3);
  const bool inside = x < scene.width && y < scene.height;

  PixelBatch batch;
  [[maybe_unused]] Guides guides{};
  for (std::uint32_t s = 0; s < stripe.samples; ++s) {
    const std::uint64_t number = stripe.film_sample + s;
    for (int i = 0; i < strata; ++i) slots.x[32 * i + static_cast<int>(lane)] = -1.0f;
    Sample sample{};
    if (inside) {
      const CameraSample<kF, TextureVolume> ray(scene, x, y, number);
      put_ray(rays, static_cast<int>(lane), ray.camera.ray);
      if constexpr (kF.has(Feature::kGuides)) {
        if (number < kGuidedSamples) guides += guides_along(scene, ray.camera.ray, ray.sight.span);
      }
      float transmittance = 1.0f;
      if (ray.sight.span.begin < ray.sight.span.end) {
        const FirstWalk first =
            walk_camera_ray<kF>(scene, ray, [&](int kind, std::int32_t stratum, Hit hit) {
              const int slot =
                  32 * (begin_of(scene.exact, kind) + stratum) + static_cast<int>(lane);
              slots.x[slot] = hit.distance;
              slots.y[slot] = hit.value;
            });
        transmittance = first.transmittance;
        sample.met_matter = first.met_matter;
      }
      sample.met_matter |= ray.sight.slice;
      // Less than half a level of the display is not seen of it.
      sample.shows_slice = ray.sight.slice && transmittance > 0.5f / 255.0f;
      sample.radiance = ray.sight.behind * transmittance;
    }
    __syncwarp();
    light_hits<kF>(scene, x0, y0, number, strata, slots, rays);
    __syncwarp();
    if (inside) {
      Float3 sum{0.0f, 0.0f, 0.0f};
      for (int i = 0; i < strata; ++i) sum += slots.at(32 * i + static_cast<int>(lane));
      batch.add(sum + sample.radiance, sample.met_matter, number, sample.shows_slice);
    }
    __syncwarp();
  }
  if (!inside) return;
  const std::uint64_t pixel = x + std::uint64_t{scene.width} * y;
  add_batch(target, pixel, batch);
  if constexpr (kF.has(Feature::kGuides)) add_guides(target, pixel, stripe, guides);
}

}  // namespace diaphane::render::cuda
