#pragma once

#include <cstdint>

#include "renderd/math/host_device.h"

namespace diaphane::render {

/// Returns the IEEE 754 binary16 number nearest to a finite `x`. Numbers beyond its range become
/// the largest finite number, and numbers below 2^-14 become 0. The conversion uses integer
/// operations on the bits, so that both engines store the same number.
HOST_DEVICE std::uint16_t to_half(float x) {
  union Bits {
    float f;
    std::uint32_t u;
  } b{x};
  const std::uint32_t sign = b.u >> 16 & 0x8000u;
  b.u &= 0x7fffffffu;
  if (b.u >= 0x477ff000u) return static_cast<std::uint16_t>(sign | 0x7bffu);
  if (b.u < 0x38800000u) return static_cast<std::uint16_t>(sign);
  const std::uint32_t rounded = b.u + 0xfffu + (b.u >> 13 & 1u);
  return static_cast<std::uint16_t>(sign | ((rounded - 0x38000000u) >> 13));
}

/// Returns the value of a binary16 number that to_half() returned.
HOST_DEVICE float from_half(std::uint16_t half) {
#if defined(__CUDA_ARCH__)
  float f;
  asm("cvt.f32.f16 %0, %1;" : "=f"(f) : "h"(half));
  return f;
#else
  union Bits {
    std::uint32_t u;
    float f;
  } b{(half & 0x7fffu) == 0 ? 0u : ((half & 0x7fffu) << 13) + 0x38000000u};
  b.u |= (half & 0x8000u) << 16;
  return b.f;
#endif
}

}  // namespace diaphane::render
