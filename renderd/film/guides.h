#pragma once

#include <cstdint>

#include "renderd/math/half.h"
#include "renderd/math/vector.h"

// What is seen through a pixel, for the denoiser: known after a few samples, when the picture is
// still noise.

namespace diaphane::render {

/// Samples of a film, from its first, that record guides. They say where edges are; more of them
/// would only say it again.
inline constexpr std::uint64_t kGuidedSamples = 4;

/// Along one camera ray, or the mean over a pixel's. Zero where nothing is seen. All but the
/// opacity are weighted by it, so that means over the samples of a pixel on an edge are right.
struct Guides {
  float opacity;  ///< 1 - transmittance
  float depth;    ///< mm from where camera rays begin: the mean over the matter seen
  Float3 albedo;
  Float3 normal;  ///< unit gradient of the voxel values where most is seen
};

/// 16 bytes.
struct alignas(16) PackedGuides {
  std::uint32_t pairs[4];
};

HOST_DEVICE PackedGuides pack(const Guides& g) {
  const auto pair = [](float a, float b) {
    return static_cast<std::uint32_t>(to_half(a)) | static_cast<std::uint32_t>(to_half(b)) << 16;
  };
  return {{pair(g.opacity, g.depth), pair(g.albedo.x, g.albedo.y), pair(g.albedo.z, g.normal.x),
           pair(g.normal.y, g.normal.z)}};
}

HOST_DEVICE Guides unpack(const PackedGuides& p) {
  const auto low = [&](int i) { return from_half(static_cast<std::uint16_t>(p.pairs[i])); };
  const auto high = [&](int i) { return from_half(static_cast<std::uint16_t>(p.pairs[i] >> 16)); };
  return {low(0), high(0), {low(1), high(1), low(2)}, {high(2), low(3), high(3)}};
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

/// The mean of `before` samples, packed, and `more` whose sum is `sum`.
HOST_DEVICE PackedGuides with_samples(const PackedGuides& mean, std::uint32_t before,
                                      const Guides& sum, std::uint32_t more) {
  if (!is_finite(sum)) return mean;
  Guides total = unpack(mean) * static_cast<float>(before);
  total += sum;
  return pack(total * (1.0f / static_cast<float>(before + more)));
}

}  // namespace diaphane::render
