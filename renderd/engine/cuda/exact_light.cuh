#pragma once

#include "renderd/engine/cuda/exact_camera.cuh"

// Kernel 2 of the exact walk, which traces rays from the hits to the lights. It is compiled by nvcc
// (ahead of time) and by NVRTC. Warps take hits from the list until it is empty. A warp aims 32
// hits together, each at a light, and pushes the rays onto a stack. A lane that is free pops the
// next ray. Some rays end after 3 cells and others after 300, so lanes that waited for the longest
// ray of their warp would idle most of the time. The result of a ray goes back to its hit, so no
// sum depends on the timing of lanes.

namespace diaphane::render::cuda {

// These values were measured on an H200 (docs/performance.md). DIAPHANE_NVRTC_OPTIONS overrides
// them.

/// Number of free lanes in a warp before they take new rays together. Starting a ray costs as much
/// as several cells, and if lanes started at different times, the others would wait each time.
#if !defined(DIAPHANE_LIGHT_REFILL)
#define DIAPHANE_LIGHT_REFILL 8
#endif
/// Number of steps before a warp checks again which work its lanes wait for.
#if !defined(DIAPHANE_LIGHT_STEPS)
#define DIAPHANE_LIGHT_STEPS(F) ((F).has(Feature::kCurves) ? 1 : 3)
#endif
/// Number of blocks that fit on a multiprocessor, which limits the registers.
#if !defined(DIAPHANE_LIGHT_BLOCKS)
#define DIAPHANE_LIGHT_BLOCKS(F) ((F).has(Feature::kCurves) ? 6 : 8)
#endif
inline constexpr int kLightBlock = 128;  ///< threads
inline constexpr int kIndirectBlocks = 8;

/// Rays that wait for a lane. A warp aims the next hits when there are fewer rays than free lanes.
struct RayStack {
  static constexpr int kRoom = 64;
  Float3 origin[kRoom], direction[kRoom];
  Span span[kRoom];
  float ending[kRoom];
  std::uint32_t hit[kRoom];
};

/// Returns the corner values of the cell that a ray crosses between two distances, and the crossing
/// in `segment`.
__device__ __forceinline__ Corners cell_between(const SceneView<TextureVolume>& scene,
                                                const Ray& ray, float from, float to,
                                                Crossing& segment) {
  const Float3 origin = ray.origin + Float3{0.5f, 0.5f, 0.5f};
  const Float3 middle = origin + ray.direction * (0.5f * (from + to));
  const ExactView& e = scene.exact;
  const auto cell_of = [](float p, std::int32_t size) {
    return min(max(static_cast<std::int32_t>(floorf(p)), 0), size);
  };
  const Int3 cell{cell_of(middle.x, e.size.x), cell_of(middle.y, e.size.y),
                  cell_of(middle.z, e.size.z)};
  const Int3 b{cell.x >> kBrickShift, cell.y >> kBrickShift, cell.z >> kBrickShift};
  segment = {origin - Float3{static_cast<float>(cell.x), static_cast<float>(cell.y),
                             static_cast<float>(cell.z)},
             ray.direction, from, to};
  return scene.volume.corners(cell,
                              scene.volume.brick(b.x + e.brick_row * b.y + e.brick_slice * b.z));
}

/// Returns the task of a hit that kernel 1 recorded.
template <Features F>
__device__ __forceinline__ HitTask task_of_record(const SceneView<TextureVolume>& scene,
                                                  const Stripe& stripe, const ExactItem* items,
                                                  const HitRecord& record, bool indirect) {
  const std::uint32_t number = record.slot / kMostHits;
  auto stratum = static_cast<std::int32_t>(record.slot % kMostHits);
  const ItemPlace at = place_of(tiles_of(scene.width, scene.height, stripe), stripe,
                                number / kTilePixels, number % kTilePixels);
  int kind = 0;
  while (stratum >= scene.exact.strata[kind]) stratum -= scene.exact.strata[kind++];
  // `indirect` is a constant at compile time, so that the light kernel contains no code for
  // continued paths.
  if (indirect) kind = kIndirect;
  CameraRay camera;
  camera.ray = {items[number].origin, items[number].direction};
  camera.direction = camera.ray.direction * scene.spacing;
  Crossing segment;
  const Corners corners = cell_between(scene, camera.ray, record.a, record.b, segment);
  const float t = place_in_cell<F.has(Feature::kCurves)>(corners, segment, scene.exact, record.c);
  const std::uint32_t pixel = scene.pixel(at.x, at.y);
  const std::uint64_t sample = scene.numbers.of(at.sample);
  const Points points(scene.stream, pixel, sample);
  const Random random(scene.seed, pixel, scene.first_sample + sample);
  return task_of<F>(scene, camera, points, random, kind, stratum,
                    Hit{t, corners.at(segment.at(t))});
}

/// Aims the hit `index` at a light and pushes the ray onto the stack if it must be walked. Takes
/// and returns the number of rays on the stack. Until the ray has been walked, the hit holds the
/// weight of its light. The whole warp must call this function. It is inline, because a call would
/// spill the registers of the rays in progress.
template <Features F>
__device__ __forceinline__ int aim(const SceneView<TextureVolume>& scene, const Stripe& stripe,
                                   const ExactScratch& scratch, std::uint32_t index,
                                   std::uint32_t total, RayStack& stack, int stacked) {
  bool walks = false;
  HitTask task;
  if (index < total) {
    HitRecord& record = scratch.hits[index];
    task =
        task_of_record<F.without(Feature::kBounces)>(scene, stripe, scratch.items, record, false);
    walks = task.lit && task.span.begin < task.span.end;
    if (!task.lit) task.weight = {0.0f, 0.0f, 0.0f};
    if (F.has(Feature::kEmission) && scratch.glow != nullptr) {
      scratch.glow[index] = {task.radiance.x, task.radiance.y, task.radiance.z, 0.0f};
    }
    record.a = task.weight.x;
    record.b = task.weight.y;
    record.c = task.weight.z;
  }
  const std::uint32_t which = __ballot_sync(~0u, walks), lane = threadIdx.x % 32;
  if (walks) {
    const int to = stacked + __popc(which & ((1u << lane) - 1u));
    stack.origin[to] = task.ray.origin;
    stack.direction[to] = task.ray.direction;
    stack.span[to] = task.span;
    stack.ending[to] = task.ending;
    stack.hit[to] = index;
  }
  return stacked + __popc(which);
}

template <std::uint32_t Bits>
__global__ void __launch_bounds__(kLightBlock, DIAPHANE_LIGHT_BLOCKS(Features{Bits}))
    light_kernel(const __grid_constant__ SceneView<TextureVolume> scene,
                 const __grid_constant__ Stripe stripe,
                 const __grid_constant__ ExactScratch scratch) {
  constexpr Features kF{Bits};
  constexpr bool kCurved = kF.has(Feature::kCurves);
  __shared__ RayStack stacks[kLightBlock / 32];
  RayStack& stack = stacks[threadIdx.x / 32];
  const std::uint32_t lane = threadIdx.x % 32, below = (1u << lane) - 1u;
  const std::uint32_t total = scratch.counters[kLightHits];
  int stacked = 0;
  bool more = true;
  // The work that a lane waits for.
  enum Wants : int { kRay, kCell, kNewParts, kPart } wants = kRay;
  constexpr std::uint32_t kNoHit = ~0u;
  std::uint32_t hit = kNoHit;
  TransmittanceWalk<kF, TextureVolume> walk;
  CellCrossing<TextureVolume> passed;
  /// Updates `wants` after a step.
  const auto go_on = [&] {
    wants = !kCurved || !walk.in_parts() ? kCell : walk.at_new_parts() ? kNewParts : kPart;
    if (walk.ended()) wants = kRay;
  };
  /// Stores the results of the rays that have ended since the last call, for several lanes
  /// together.
  const auto note = [&] {
    if (hit == kNoHit || wants != kRay) return;
    const float visibility = walk.transmittance();
    HitRecord& record = scratch.hits[hit];
    record.a *= visibility;
    record.b *= visibility;
    record.c *= visibility;
    hit = kNoHit;
  };
  for (;;) {
    const std::uint32_t idle = __ballot_sync(~0u, wants == kRay);
    const int free = __popc(idle);
    if (free >= ((more || stacked > 0) ? DIAPHANE_LIGHT_REFILL : 32)) {
      note();
      while (more && stacked < free) {
        std::uint32_t base = 0;
        if (lane == 0) base = atomicAdd(scratch.counters + kLightTaken, 32u);
        base = __shfl_sync(~0u, base, 0);
        more = base + 32 < total;
        stacked = aim<kF>(scene, stripe, scratch, base + lane, total, stack, stacked);
      }
      if (stacked == 0 && free == 32) return;
      __syncwarp();
      const int from = stacked - 1 - __popc(idle & below);
      if (wants == kRay && from >= 0) {
        walk = TransmittanceWalk<kF, TextureVolume>(Ray{stack.origin[from], stack.direction[from]},
                                                    stack.span[from], scene.volume, scene.exact,
                                                    stack.ending[from]);
        hit = stack.hit[from];
        go_on();
      }
      stacked = max(stacked - free, 0);
      __syncwarp();
    }
    // The work that most lanes wait for is done next.
    Wants now = kCell;
    if constexpr (kCurved) {
      const auto waiting = [&](Wants w) { return __popc(__ballot_sync(~0u, wants == w)); };
      const int cells = waiting(kCell), fresh = waiting(kNewParts), parts = waiting(kPart);
      if (fresh > cells && fresh >= parts) now = kNewParts;
      if (parts > cells && parts > fresh) now = kPart;
    }
    if (kCurved && now != kCell) {
      if (wants == now) {
        if (now == kNewParts) {
          walk.begin_parts(scene.volume, scene.exact);
        } else {
          walk.step_part(scene.volume, scene.exact, passed);
        }
        go_on();
      }
      continue;
    }
#pragma unroll
    for (int i = 0; i < DIAPHANE_LIGHT_STEPS(kF); ++i) {
      if (wants == kCell) {
        walk.step_cell(scene.volume, scene.exact, passed);
        go_on();
      }
    }
  }
}

/// Continues the paths of Feature::kBounces from their first collision, with one thread per hit.
template <std::uint32_t Bits>
__global__ void __launch_bounds__(kLightBlock, kIndirectBlocks)
    indirect_kernel(const __grid_constant__ SceneView<TextureVolume> scene,
                    const __grid_constant__ Stripe stripe,
                    const __grid_constant__ ExactScratch scratch) {
  const std::uint32_t i = blockIdx.x * kLightBlock + threadIdx.x;
  const std::uint32_t step = gridDim.x * kLightBlock;
  for (std::uint32_t n = i; n < scratch.counters[kIndirectHits]; n += step) {
    HitRecord& record = scratch.hits[scratch.indirect + n];
    const Float3 light = task_of_record<Features{Bits}.with(Feature::kBounces)>(
                             scene, stripe, scratch.items, record, true)
                             .radiance;
    record.a = light.x;
    record.b = light.y;
    record.c = light.z;
  }
}

}  // namespace diaphane::render::cuda
