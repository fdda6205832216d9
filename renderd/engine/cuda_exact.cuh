#pragma once

#include "renderd/engine/cuda_trace.cuh"
#include "renderd/kernel/exact_estimator.h"

// The exact walk, for nvcc (ahead of time) and for NVRTC. A block takes 8 x 4 pixels, in three
// stages with a barrier between:
//  1. one warp walks the camera rays and notes in which cells they collide;
//  2. all warps find the places in those cells, and a ray from each to a light. What differs by
//  kind
//     of light differs by stratum, and a warp has one stratum of all pixels: it does not diverge;
//  3. all lanes walk those rays, whoever is free the next: a ray ends after 3 cells or after 300,
//     and a lane that waited for the longest of its warp would idle most of the time.
// Hits and their light lie in shared memory, each in a slot of its own, so the sum at the end does
// not depend on who was free when.

namespace diaphane::render::cuda {

/// Blocks that fit on a multiprocessor: caps the registers.
#if !defined(DIAPHANE_EXACT_BLOCKS)
#define DIAPHANE_EXACT_BLOCKS 8
#endif
/// So many lanes of a warp must be free before they take new rays together: starting one costs as
/// much as some cells, and lanes that start at different times would make the others wait each
/// time.
#if !defined(DIAPHANE_EXACT_REFILL)
#define DIAPHANE_EXACT_REFILL 8
#endif
/// Steps between two looks at who is free.
#if !defined(DIAPHANE_EXACT_STEPS)
#define DIAPHANE_EXACT_STEPS 2
#endif

inline constexpr int kTilePixels = 32;  ///< of a block: 8 x 4
inline constexpr int kExactWarps = kTraceBlock / 32;

/// What a slot holds; one is a stratum of a pixel, the 32 pixels of a stratum lie side by side.
enum SlotField : int {
  kFrom,        ///< stage 1: where the ray enters the cell; negative: no hit. Stage 2: the hit
  kTo,          ///< stage 1: where it leaves it. Stage 2: distance to the light; negative: no ray
  kDepth,       ///< stage 1: optical depth from entry to hit. Stage 2: TransmittanceWalk's ending
  kDirectionX,  ///< of the ray to the light
  kDirectionY,
  kDirectionZ,
  kRed,  ///< stage 2: weight of the ray. Stage 3: light of the hit
  kGreen,
  kBlue,
  kSlotFields,
  // Only where matter glows: its own light.
  kOwnRed = kSlotFields,
  kOwnGreen,
  kOwnBlue,
  kGlowingSlotFields
};

/// The block's shared memory: rays of the pixels, slots, list of rays to be walked.
struct ExactShared {
  float* rays;
  float* slots;
  std::uint16_t* list;
  int strata;

  __device__ __forceinline__ ExactShared(float* memory, int strata, int fields)
      : rays(memory),
        slots(memory + 6 * kTilePixels),
        list(reinterpret_cast<std::uint16_t*>(memory + (6 + fields * strata) * kTilePixels)),
        strata(strata) {}

  __device__ __forceinline__ float& at(SlotField field, int slot) const {
    return slots[field * kTilePixels * strata + slot];
  }
  __device__ __forceinline__ void put_ray(int pixel, const Ray& ray) const {
    const float numbers[6] = {ray.origin.x,    ray.origin.y,    ray.origin.z,
                              ray.direction.x, ray.direction.y, ray.direction.z};
    for (int i = 0; i < 6; ++i) rays[kTilePixels * i + pixel] = numbers[i];
  }
  __device__ __forceinline__ Ray ray(int pixel) const {
    const float* r = rays + pixel;
    return {{r[0], r[32], r[64]}, {r[96], r[128], r[160]}};
  }
};
HOST_DEVICE std::uint32_t exact_shared_bytes(Features features, std::uint32_t strata) {
  const std::uint32_t fields = features.has(Feature::kEmission) ? kGlowingSlotFields : kSlotFields;
  return kTilePixels * (4 * (6 + fields * strata) + 2 * strata);
}

/// Where a kind's strata begin among all.
HOST_DEVICE std::int32_t begin_of(const ExactView& exact, int kind) {
  std::int32_t begin = 0;
  for (int k = 0; k < kind; ++k) begin += exact.strata[k];
  return begin;
}

/// Stage 1, a lane a pixel: the sample without the light of its hits.
template <Features F>
__device__ __forceinline__ Sample mark_hits(const SceneView<TextureVolume>& scene,
                                            const ExactShared& shared, std::uint32_t x,
                                            std::uint32_t y, std::uint64_t number, int pixel,
                                            [[maybe_unused]] Guides& guides) {
  const CameraSample<F, TextureVolume> camera(scene, x, y, number);
  shared.put_ray(pixel, camera.camera.ray);
  if constexpr (F.has(Feature::kGuides)) {
    if (number < kGuidedSamples)
      guides += guides_along(scene, camera.camera.ray, camera.sight.span);
  }
  Sample sample{};
  float transmittance = 1.0f;
  if (camera.sight.span.begin < camera.sight.span.end) {
    const FirstWalk first = walk_camera_ray<F>(
        scene, camera,
        [&](int kind, std::int32_t stratum, const Corners&, const Crossing& way, float depth) {
          const int slot = kTilePixels * (begin_of(scene.exact, kind) + stratum) + pixel;
          shared.at(kFrom, slot) = way.t0;
          shared.at(kTo, slot) = way.t1;
          shared.at(kDepth, slot) = depth;
        });
    transmittance = first.transmittance;
    sample.met_matter = first.met_matter;
  }
  sample.met_matter |= camera.sight.slice;
  // Less than half a level of the display is not seen of it.
  sample.shows_slice = camera.sight.slice && transmittance > 0.5f / 255.0f;
  sample.radiance = camera.sight.behind * transmittance;
  return sample;
}

/// The crossing of the cell in which a ray is between two distances, and its corners.
__device__ __forceinline__ Corners cell_between(const SceneView<TextureVolume>& scene,
                                                const Ray& ray, float from, float to,
                                                Crossing& way) {
  const Float3 origin = ray.origin + Float3{0.5f, 0.5f, 0.5f};
  const Float3 middle = origin + ray.direction * (0.5f * (from + to));
  const ExactView& e = scene.exact;
  const auto cell_of = [](float p, std::int32_t size) {
    return smaller(larger(static_cast<std::int32_t>(floorf(p)), 0), size);
  };
  CellCrossing c;
  c.cell = {cell_of(middle.x, e.size.x), cell_of(middle.y, e.size.y), cell_of(middle.z, e.size.z)};
  c.brick = (c.cell.x >> kBrickShift) +
            e.bricks.x * ((c.cell.y >> kBrickShift) + e.bricks.y * (c.cell.z >> kBrickShift));
  c.way.entry = origin + ray.direction * from -
                Float3{static_cast<float>(c.cell.x), static_cast<float>(c.cell.y),
                       static_cast<float>(c.cell.z)};
  c.way.slope = ray.direction;
  c.way.t0 = from;
  c.way.t1 = to;
  way = c.way;
  return scene.volume.corners(c);
}

/// Stage 2, one slot: from hit to ray; whether there is one to be walked.
template <Features F>
__device__ __forceinline__ bool aim(const SceneView<TextureVolume>& scene,
                                    const ExactShared& shared, std::uint32_t index,
                                    std::uint64_t number, int stratum, int pixel) {
  const int slot = kTilePixels * stratum + pixel;
  const float from = shared.at(kFrom, slot);
  if (from < 0.0f) {
    shared.at(kRed, slot) = shared.at(kGreen, slot) = shared.at(kBlue, slot) = 0.0f;
    return false;
  }
  CameraRay camera;
  camera.ray = shared.ray(pixel);
  camera.direction = camera.ray.direction * scene.spacing;
  Crossing way;
  const Corners corners = cell_between(scene, camera.ray, from, shared.at(kTo, slot), way);
  const float t =
      place_in_cell<F.has(Feature::kCurves)>(corners, way, scene.exact, shared.at(kDepth, slot));
  int kind = 0, first = 0;
  while (stratum >= first + scene.exact.strata[kind]) first += scene.exact.strata[kind++];
  const Points points(scene.stream, index, number);
  const Random random(scene.seed, index, scene.first_sample + number);
  const HitTask task = task_of<F>(scene, camera, points, random, kind, stratum - first,
                                  Hit{t, corners.at(way.at(t))});
  if (!task.lit || !(task.span.begin < task.span.end)) {
    // Nothing is in its way.
    const Float3 light = task.lit ? task.radiance + task.weight : task.radiance;
    shared.at(kRed, slot) = light.x;
    shared.at(kGreen, slot) = light.y;
    shared.at(kBlue, slot) = light.z;
    return false;
  }
  shared.at(kFrom, slot) = t;
  shared.at(kTo, slot) = task.span.end;
  shared.at(kDepth, slot) = task.ending;
  shared.at(kDirectionX, slot) = task.ray.direction.x;
  shared.at(kDirectionY, slot) = task.ray.direction.y;
  shared.at(kDirectionZ, slot) = task.ray.direction.z;
  shared.at(kRed, slot) = task.weight.x;
  shared.at(kGreen, slot) = task.weight.y;
  shared.at(kBlue, slot) = task.weight.z;
  if constexpr (F.has(Feature::kEmission)) {
    shared.at(kOwnRed, slot) = task.radiance.x;
    shared.at(kOwnGreen, slot) = task.radiance.y;
    shared.at(kOwnBlue, slot) = task.radiance.z;
  }
  return true;
}

/// Stage 3: takes rays from the list until it is empty.
template <Features F>
__device__ __forceinline__ void walk_rays(const SceneView<TextureVolume>& scene,
                                          const ExactShared& shared, int total, int* taken) {
  const std::uint32_t lane = threadIdx.x & 31;
  bool active = false, more = true;
  int slot = 0;
  TransmittanceWalk<F> walk;
  for (;;) {
    const std::uint32_t idle = __ballot_sync(~0u, !active);
    const int free = __popc(idle);
    if (more ? free >= DIAPHANE_EXACT_REFILL : free == 32) {
      if (!more) return;
      int base = 0;
      if (lane == 0) base = atomicAdd(taken, free);
      base = __shfl_sync(~0u, base, 0);
      more = base + free < total;
      const int mine = base + __popc(idle & ((1u << lane) - 1u));
      if (!active && mine < total) {
        slot = shared.list[mine];
        const Ray camera = shared.ray(slot & (kTilePixels - 1));
        const Ray ray{camera.at(shared.at(kFrom, slot)),
                      {shared.at(kDirectionX, slot), shared.at(kDirectionY, slot),
                       shared.at(kDirectionZ, slot)}};
        const Span span = clip_span<F>(
            scene, ray, clip(ray, scene.grid.occupied, Span{0.0f, shared.at(kTo, slot)}),
            RayKind::kLight);
        walk = TransmittanceWalk<F>(ray, span, scene.exact, shared.at(kDepth, slot));
        active = true;
      }
      continue;
    }
    if (active) {
#pragma unroll 1
      for (int i = 0; i < DIAPHANE_EXACT_STEPS; ++i) {
        if (!walk.step(scene.volume, scene.exact)) {
          const float seen = walk.transmittance();
          shared.at(kRed, slot) *= seen;
          shared.at(kGreen, slot) *= seen;
          shared.at(kBlue, slot) *= seen;
          if constexpr (F.has(Feature::kEmission)) {
            shared.at(kRed, slot) += shared.at(kOwnRed, slot);
            shared.at(kGreen, slot) += shared.at(kOwnGreen, slot);
            shared.at(kBlue, slot) += shared.at(kOwnBlue, slot);
          }
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
  extern __shared__ float memory[];
  __shared__ int listed, taken;
  const int strata = begin_of(scene.exact, kHitKinds);
  const ExactShared shared(memory, strata,
                           kF.has(Feature::kEmission) ? kGlowingSlotFields : kSlotFields);
  const int warp = static_cast<int>(threadIdx.x >> 5), lane = static_cast<int>(threadIdx.x & 31);
  const std::uint32_t x = blockIdx.x * 8 + (threadIdx.x & 7);
  const std::uint32_t y = stripe.first_row + blockIdx.y * 4 + (threadIdx.x >> 3 & 3);
  const bool inside = x < scene.width && y < scene.height;

  PixelBatch batch;
  [[maybe_unused]] Guides guides{};
  for (std::uint32_t s = 0; s < stripe.samples; ++s) {
    const std::uint64_t number = stripe.film_sample + s;
    for (int i = static_cast<int>(threadIdx.x); i < kTilePixels * strata; i += kTraceBlock) {
      shared.at(kFrom, i) = -1.0f;
    }
    if (threadIdx.x == 0) listed = taken = 0;
    __syncthreads();
    Sample sample{};
    if (warp == 0 && inside) sample = mark_hits<kF>(scene, shared, x, y, number, lane, guides);
    __syncthreads();
    for (int stratum = warp; stratum < strata; stratum += kExactWarps) {
      const bool walks = aim<kF>(scene, shared, x + scene.width * y, number, stratum, lane);
      const std::uint32_t which = __ballot_sync(~0u, walks);
      int base = 0;
      if (lane == 0) base = atomicAdd(&listed, __popc(which));
      base = __shfl_sync(~0u, base, 0);
      if (walks) {
        shared.list[base + __popc(which & ((1u << lane) - 1u))] =
            static_cast<std::uint16_t>(kTilePixels * stratum + lane);
      }
    }
    __syncthreads();
    walk_rays<kF>(scene, shared, listed, &taken);
    __syncthreads();
    if (warp == 0 && inside) {
      Float3 sum = sample.radiance;
      for (int i = lane; i < kTilePixels * strata; i += kTilePixels) {
        sum += Float3{shared.at(kRed, i), shared.at(kGreen, i), shared.at(kBlue, i)};
      }
      batch.add(sum, sample.met_matter, number, sample.shows_slice);
    }
    __syncthreads();
  }
  if (warp != 0 || !inside) return;
  const std::uint64_t pixel = x + std::uint64_t{scene.width} * y;
  add_batch(target, pixel, batch);
  if constexpr (kF.has(Feature::kGuides)) add_guides(target, pixel, stripe, guides);
}

}  // namespace diaphane::render::cuda
