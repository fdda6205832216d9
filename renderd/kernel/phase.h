#pragma once

#include "renderd/math/vector.h"

namespace diaphane::render {

inline constexpr float kPi = 3.14159265358979f;
inline constexpr float kIsotropicPhase = 0.0795774715459477f;  ///< 1 / (4 pi), per steradian

/// Returns the Henyey-Greenstein phase function, per steradian. `in` and `out` are the unit
/// directions in which light travels before and after the collision; both may be reversed together.
/// The result is accurate for any g in (-1, 1), because the denominator sums two terms that are not
/// negative: (1 - |g|)^2, and 2 |g| (1 - cos) or, for g < 0, 2 |g| (1 + cos).
HOST_DEVICE float henyey_greenstein(float g, Float3 in, Float3 out) {
  const float a = fabsf(g);
  const Float3 d = g < 0.0f ? in + out : in - out;
  const float one_minus_cos = 0.5f * dot(d, d);
  const float o = 1.0f - a;
  const float denominator = o * o + 2.0f * a * one_minus_cos;
  return kIsotropicPhase * o * (1.0f + a) / (denominator * sqrtf(denominator));
}

/// Samples 1 - cos of the Henyey-Greenstein angle for 0 <= g < 1, with u in [0, 1], without
/// cancellation near g = 1 or near the forward direction. For g < 0, sample with |g| and mirror.
HOST_DEVICE float sample_one_minus_cos(float g, float u) {
  const float o = 1.0f - g;
  const float d = o + 2.0f * g * u;
  const float s = o * (1.0f + g) / d;
  return o * (1.0f - u) * (s + o) / d;
}

/// A point on the unit circle; `turn` in [0, 1) is a fraction of a full turn.
struct CirclePoint {
  float cosine, sine;
};
HOST_DEVICE CirclePoint on_circle(float turn) {
#if defined(__CUDA_ARCH__)
  // This avoids the reduction of large angles, which do not occur.
  CirclePoint p;
  sincospif(2.0f * turn, &p.sine, &p.cosine);
  return p;
#else
  const float angle = 2.0f * kPi * turn;
  return {cosf(angle), sinf(angle)};
#endif
}

/// Samples a unit direction from Henyey-Greenstein around the unit direction `in`; g in (-1, 1).
HOST_DEVICE Float3 sample_henyey_greenstein(float g, Float3 in, float u, float v) {
  const float c = min(sample_one_minus_cos(fabsf(g), u), 2.0f);
  const float sine = sqrtf(max(c * (2.0f - c), 0.0f));
  const float cosine = g < 0.0f ? c - 1.0f : 1.0f - c;
  Float3 s, t;
  basis_around(in, s, t);
  const CirclePoint p = on_circle(v);
  return s * (sine * p.cosine) + t * (sine * p.sine) + in * cosine;
}

/// Samples a unit direction uniformly over the sphere.
HOST_DEVICE Float3 sample_sphere(float u, float v) {
  const float z = 1.0f - 2.0f * u;
  const float r = 2.0f * sqrtf(max(u * (1.0f - u), 0.0f));
  const CirclePoint p = on_circle(v);
  return {r * p.cosine, r * p.sine, z};
}

}  // namespace diaphane::render
