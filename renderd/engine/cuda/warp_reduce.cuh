#pragma once

#include <cstdint>

// Reductions over a warp, in which all lanes must participate. From compute capability 8.0 on, each
// is one instruction.

namespace diaphane::render {

#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ < 800

template <typename Value, typename Combine>
__device__ __forceinline__ Value warp_reduce(Value value, const Combine& combine) {
  for (int distance = 16; distance > 0; distance /= 2) {
    value = combine(value, __shfl_xor_sync(~0u, value, distance));
  }
  return value;
}
__device__ __forceinline__ std::int32_t warp_min(std::int32_t value) {
  return warp_reduce(value, [](std::int32_t a, std::int32_t b) { return a < b ? a : b; });
}
__device__ __forceinline__ std::int32_t warp_max(std::int32_t value) {
  return warp_reduce(value, [](std::int32_t a, std::int32_t b) { return a > b ? a : b; });
}
__device__ __forceinline__ std::uint32_t warp_sum(std::uint32_t value) {
  return warp_reduce(value, [](std::uint32_t a, std::uint32_t b) { return a + b; });
}

#else

__device__ __forceinline__ std::int32_t warp_min(std::int32_t value) {
  return __reduce_min_sync(~0u, value);
}
__device__ __forceinline__ std::int32_t warp_max(std::int32_t value) {
  return __reduce_max_sync(~0u, value);
}
__device__ __forceinline__ std::uint32_t warp_sum(std::uint32_t value) {
  return __reduce_add_sync(~0u, value);
}

#endif

}  // namespace diaphane::render
