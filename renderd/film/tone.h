#pragma once

#include <cstdint>

#include "renderd/math/tone_curve.h"
#include "renderd/math/vector.h"

namespace diaphane::render {

/// Returns x^(1/2.2) for x in [0, 1], with an absolute error below 3e-6 and 0 for 0. The function
/// has no branch and vectorises. The whole picture is converted several times per second, and powf
/// would make that more expensive than a sample.
HOST_DEVICE float gamma_encode(float x) {
  union Bits {
    float f;
    std::int32_t i;
  } b{max(x, 0x1p-60f)};
  // x = m 2^e, m in [0.75, 1.5); log(m) = 2 atanh((m - 1) / (m + 1)).
  const std::int32_t e = (b.i - 0x3f400000) >> 23;
  b.i -= e * (1 << 23);
  const float s = (b.f - 1.0f) / (b.f + 1.0f);
  const float q = s * s;
  const float log2_m =
      s * (2.88539008f + q * (0.961796694f + q * (0.577078016f + q * 0.412198583f)));
  // The log2 of the result, in [-27.3, 0].
  const float y = (static_cast<float>(e) + log2_m) * (1.0f / 2.2f);
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

/// Returns the display curve: clip(x, 0, 1)^(1/2.2), or film_curve(x)^(1/2.2).
HOST_DEVICE float tone(float x, ToneCurve curve = ToneCurve::kLinear) {
  return gamma_encode(curve == ToneCurve::kFilmic ? film_curve(x) : min(max(x, 0.0f), 1.0f));
}

/// Converts `radiance` times `scale` (2^exposure, for example) to 8 bits by the display curve.
HOST_DEVICE std::uint8_t to_display(float radiance, float scale,
                                    ToneCurve curve = ToneCurve::kLinear) {
  return static_cast<std::uint8_t>(tone(radiance * scale, curve) * 255.0f + 0.5f);
}

}  // namespace diaphane::render
