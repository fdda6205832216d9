#pragma once

#include <cmath>
#include <cstdint>

#include "renderd/math/vector.h"

namespace diaphane::render {

/// The curve that maps radiance to the linear light of the screen, before gamma encoding.
enum class ToneCurve : std::uint8_t {
  kLinear,  ///< the identity, clipped at 1
  kFilmic,  ///< film_curve()
};

// The filmic curve y = x (a x + b) / (x (c x + d) + e) is the fit by Narkowicz (2016) to the
// tone mapping of ACES. Applied to each component, it has a toe, and a shoulder that lets
// highlights fade to white. A radiance of 1 becomes 0.804.
inline constexpr float kFilmA = 2.51f, kFilmB = 0.03f, kFilmC = 2.43f, kFilmD = 0.59f,
                       kFilmE = 0.14f;
/// The radiance that becomes 1: the root of (a - c) x^2 + (b - d) x - e.
inline constexpr float kFilmWhite = 7.24165739f;

/// Returns the value of the filmic curve at the radiance `x`, in [0, 1].
HOST_DEVICE float film_curve(float x) {
  x = min(max(x, 0.0f), kFilmWhite);
  const float y = x * (kFilmA * x + kFilmB) / (x * (kFilmC * x + kFilmD) + kFilmE);
  return min(y, 1.0f);
}

/// Returns the radiance that film_curve() maps to `y` in [0, 1].
HOST_DEVICE float film_radiance(float y) {
  const float p = kFilmA - kFilmC * y, q = kFilmB - kFilmD * y, r = kFilmE * y;
  const float root = sqrtf(q * q + 4.0f * p * r);
  // Neither form subtracts numbers that are nearly equal.
  return q > 0.0f ? 2.0f * r / (q + root) : (root - q) / (2.0f * p);
}

}  // namespace diaphane::render
