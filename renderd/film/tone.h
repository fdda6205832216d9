#pragma once

#include <cstdint>

#include "renderd/math/vector.h"

namespace diaphane::render {

/// The display curve: clip(x, 0, 1)^(1/2.2).
HOST_DEVICE float tone(float x) { return powf(smaller(larger(x, 0.0f), 1.0f), 1.0f / 2.2f); }

/// `radiance` times `scale` (2^exposure, say), through the tone curve, as 8 bits.
HOST_DEVICE std::uint8_t to_display(float radiance, float scale) {
  return static_cast<std::uint8_t>(tone(radiance * scale) * 255.0f + 0.5f);
}

}  // namespace diaphane::render
