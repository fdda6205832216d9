#pragma once

#include <cstdint>

#include "renderd/math/vector.h"

namespace diaphane::render {

/// x^(1/2.2) for x in [0, 1]; absolute error below 3e-6. powf costs more than a sample where the
/// whole picture goes through it several times a second; this has no branch and vectorises. 0 gives
/// 0.
HOST_DEVICE float gamma_encode(float x) {
  union Bits {
    float f;
    std::int32_t i;
  } b{larger(x, 0x1p-60f)};
  // x = m 2^e, m in [0.75, 1.5); log(m) = 2 atanh((m - 1) / (m + 1)).
  const std::int32_t e = (b.i - 0x3f400000) >> 23;
  b.i -= e * (1 << 23);
  const float s = (b.f - 1.0f) / (b.f + 1.0f);
  const float q = s * s;
  const float log2_m =
      s * (2.88539008f + q * (0.961796694f + q * (0.577078016f + q * 0.412198583f)));
  const float y =
      (static_cast<float>(e) + log2_m) * (1.0f / 2.2f);  // log2 of the result, in [-27.3, 0]
  // 2^y = 2^k 2^f, f in [-0.5, 0.5].
  const std::int32_t k = static_cast<std::int32_t>(y - 0.5f);
  const float f = y - static_cast<float>(k);
  const float p =
      1.0f +
      f * (0.693147182f +
           f * (0.240226462f + f * (0.0555041087f + f * (0.00961812911f + f * 0.00133335581f))));
  b.i = (k + 127) * (1 << 23);
  return x > 0x1p-60f ? p * b.f : 0.0f;
}

/// The display curve: clip(x, 0, 1)^(1/2.2).
HOST_DEVICE float tone(float x) { return gamma_encode(smaller(larger(x, 0.0f), 1.0f)); }

/// `radiance` times `scale` (2^exposure, say), through the tone curve, as 8 bits.
HOST_DEVICE std::uint8_t to_display(float radiance, float scale) {
  return static_cast<std::uint8_t>(tone(radiance * scale) * 255.0f + 0.5f);
}

}  // namespace diaphane::render
