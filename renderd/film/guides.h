#pragma once

#include <cstdint>

#include "renderd/math/half.h"
#include "renderd/math/vector.h"

// Features of the matter that is visible through a pixel, for the denoiser. A few samples suffice
// to determine them, while the picture is still noisy.

namespace diaphane::render {

/// Number of samples, from the first sample of a film, that record guides. Guides show where edges
/// are, and further samples would add little.
inline constexpr std::uint64_t kGuidedSamples = 4;

/// The guides of one camera ray, or their mean over the samples of a pixel. All are zero where
/// nothing is visible. All except the opacity are weighted by the opacity, so that the means are
/// right for a pixel on an edge.
struct Guides {
  float opacity;  ///< 1 - transmittance
  float depth;    ///< mm from the start of the camera ray: the mean over the visible matter
  Float3 albedo;
  Float3 normal;  ///< unit gradient of the voxel values where visibility is highest
};

/// The guides of a pixel in 6 bytes, which a session keeps while its pictures are denoised. From
/// the lowest bit up: depth over opacity as a half without its sign (15 bits), the lowest bit of
/// the opacity, albedo in 31, 63 and 31 steps (16), normal in 14 steps from -1 to 1 each (12), and
/// the other bits of the opacity in 31 steps (4). All are far finer than an edge (DenoiseTuning).
struct PackedGuides {
  std::uint16_t words[3];
};

/// Returns the number of the step nearest to `x` in [0, 1].
HOST_DEVICE std::uint32_t in_steps(float x, float steps) {
  return static_cast<std::uint32_t>(min(max(x, 0.0f), 1.0f) * steps + 0.5f);
}

HOST_DEVICE PackedGuides pack(const Guides& g) {
  // Rounding must not make visible matter invisible.
  const std::uint32_t opacity = g.opacity > 0.0f ? max(in_steps(g.opacity, 31.0f), 1u) : 0u;
  const float depth = g.opacity > 0.0f ? max(g.depth / g.opacity, 0.0f) : 0.0f;
  const auto side = [](float x) { return in_steps(0.5f + 0.5f * x, 14.0f); };
  const std::uint32_t albedo = in_steps(g.albedo.x, 31.0f) | in_steps(g.albedo.y, 63.0f) << 5 |
                               in_steps(g.albedo.z, 31.0f) << 11;
  const std::uint32_t normal = side(g.normal.x) | side(g.normal.y) << 4 | side(g.normal.z) << 8;
  return {{static_cast<std::uint16_t>(to_half(depth) | (opacity & 1u) << 15),
           static_cast<std::uint16_t>(albedo),
           static_cast<std::uint16_t>(normal | opacity >> 1 << 12)}};
}

HOST_DEVICE Guides unpack(const PackedGuides& p) {
  const std::uint32_t albedo = p.words[1], normal = p.words[2];
  const auto steps = [](std::uint32_t n, float count) {
    return static_cast<float>(n) * (1.0f / count);
  };
  const auto side = [](std::uint32_t n) {
    return (static_cast<float>(n & 15u) - 7.0f) * (1.0f / 7);
  };
  const float opacity = steps(p.words[0] >> 15 | (normal >> 12) << 1, 31.0f);
  Guides g{opacity, from_half(p.words[0] & 0x7fffu) * opacity, {}, {}};
  g.albedo = {steps(albedo & 31u, 31.0f), steps(albedo >> 5 & 63u, 63.0f),
              steps(albedo >> 11, 31.0f)};
  // The zeros of a cleared pixel would otherwise decode to the normal (-1, -1, -1).
  if (opacity > 0.0f) g.normal = {side(normal), side(normal >> 4), side(normal >> 8)};
  return g;
}

HOST_DEVICE Guides& operator+=(Guides& a, const Guides& b) {
  a.opacity += b.opacity;
  a.depth += b.depth;
  a.albedo += b.albedo;
  a.normal += b.normal;
  return a;
}
HOST_DEVICE Guides operator*(const Guides& a, float s) {
  return {a.opacity * s, a.depth * s, a.albedo * s, a.normal * s};
}
HOST_DEVICE bool is_finite(const Guides& g) {
  return is_finite(Float3{g.opacity, g.depth, 0.0f} + g.albedo + g.normal);
}

/// Returns the mean of `before` samples, whose packed mean is `mean`, and `more` samples, whose sum
/// is `sum`.
HOST_DEVICE PackedGuides with_samples(const PackedGuides& mean, std::uint32_t before,
                                      const Guides& sum, std::uint32_t more) {
  if (!is_finite(sum)) return mean;
  Guides total = unpack(mean) * static_cast<float>(before);
  total += sum;
  return pack(total * (1.0f / static_cast<float>(before + more)));
}

}  // namespace diaphane::render
