#pragma once

#include <cstdint>

#include "renderd/film/film.h"
#include "renderd/film/guides.h"
#include "renderd/math/half.h"

// Denoises the first pictures of a view, which are still noisy. The guides and the variance of the
// picture (Schied et al. 2017, without the temporal part) steer an edge-avoiding a-trous filter
// (Dammertz et al. 2010). The result is then blended with the raw picture so that the error is
// minimal.
//
// The blend: let M be the raw picture, F the filtered one and d the deviation of M (film.h: E[d^2]
// = Var[M], independent of the mean of M). The squared error of M + w (F - M) is minimal at
//   w = E[(M - truth) (M - F)] / E[(F - M)^2]   and   E[(M - truth) (M - F)] = E[d (d - F_d)],
// where F_d is the filtered d. This is exact for a filter whose weights do not depend on the noise.
// Both means are taken over a tile and its neighbours. The numerator falls as 1 / samples, and the
// denominator approaches the squared bias of the filter. So w approaches 0, and the final picture
// is the raw one.
//
// Every function works on one pixel or on a pair of pixels; the engines supply loops and memory.

namespace diaphane::render {

/// Number of passes. A pass has 5 x 5 taps, which are 1, 2, 4 and 8 pixels apart in turn.
inline constexpr std::uint32_t kDenoisePasses = 4;
inline constexpr std::int32_t kDenoiseReach = 2;

/// The variance is the mean of d^2 over this many pixels in each direction, because d^2 of a single
/// pixel is too noisy.
inline constexpr std::int32_t kVarianceReach = 3;

/// Returns the weight of a tap along one axis, `tap` taps from the centre, from the B3 spline.
HOST_DEVICE float spline_weight(std::int32_t tap) {
  constexpr float kWeights[] = {3.0f / 8.0f, 1.0f / 4.0f, 1.0f / 16.0f};
  return kWeights[tap < 0 ? -tap : tap];
}

/// The quantities that are filtered, in units of the picture's white.
struct Smoothed {
  Float3 mean;
  float deviation;  ///< of the luminance
};

/// The data that steers the filter at a pixel.
struct Steering {
  float takes_part;  ///< 1, or 0 if the pixel contributes nothing to other pixels
  float opacity, depth;
  Float3 albedo, normal;
};

HOST_DEVICE float luminance(Float3 c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

/// The value at which the filter clips brighter pixels, in units of white, so that a single bright
/// path does not light up its surroundings.
inline constexpr float kBrightest = 16.0f;

HOST_DEVICE float bounded(float x, float low, float high) {
  return max(min(x, high), low);  // NaN becomes `high`, but callers test for it before
}

HOST_DEVICE Smoothed to_be_smoothed(const PixelEstimate& e, float inverse_white) {
  const Float3 m = e.mean * inverse_white;
  const float d = luminance(e.deviation) * inverse_white;
  Smoothed s{{0.0f, 0.0f, 0.0f}, 0.0f};
  if (is_finite(m)) {
    s.mean = {bounded(m.x, 0.0f, kBrightest), bounded(m.y, 0.0f, kBrightest),
              bounded(m.z, 0.0f, kBrightest)};
  }
  if (d - d == 0.0f) s.deviation = bounded(d, -kBrightest, kBrightest);
  return s;
}

HOST_DEVICE Steering steering_of(const Guides& g, bool takes_part) {
  Steering s;
  s.takes_part = takes_part ? 1.0f : 0.0f;
  s.opacity = g.opacity;
  s.depth = g.opacity > 0.0f ? g.depth / g.opacity : 0.0f;
  s.albedo = g.albedo;
  s.normal = g.normal;
  return s;
}

/// Steering data as half floats, in 16 bytes. A negative opacity marks a pixel that contributes
/// nothing to other pixels. Both engines filter with the packed values, so that they agree.
struct alignas(16) PackedSteering {
  std::uint32_t pairs[4];
};
HOST_DEVICE PackedSteering pack(const Steering& s) {
  const auto pair = [](float a, float b) {
    return static_cast<std::uint32_t>(to_half(a)) | static_cast<std::uint32_t>(to_half(b)) << 16;
  };
  return {{pair(s.takes_part > 0.0f ? s.opacity : -1.0f, s.depth), pair(s.albedo.x, s.albedo.y),
           pair(s.albedo.z, s.normal.x), pair(s.normal.y, s.normal.z)}};
}
HOST_DEVICE Steering unpack(const PackedSteering& p) {
  const auto low = [&](int i) { return from_half(static_cast<std::uint16_t>(p.pairs[i])); };
  const auto high = [&](int i) { return from_half(static_cast<std::uint16_t>(p.pairs[i] >> 16)); };
  const bool part = low(0) >= 0.0f;
  return {part ? 1.0f : 0.0f,
          part ? low(0) : 0.0f,
          high(0),
          {low(1), high(1), low(2)},
          {high(2), low(3), high(3)}};
}

/// Returns an approximation of exp(-x) for x >= 0, which is 0 for x >= 8.
HOST_DEVICE float falloff(float x) {
  const float t = max(1.0f - 0.125f * x, 0.0f);
  const float t2 = t * t, t4 = t2 * t2;
  return t4 * t4;
}

HOST_DEVICE float squared(float x) { return x * x; }
HOST_DEVICE float squared(Float3 x) { return dot(x, x); }

struct DenoiseTuning {
  float opacity = 1.0f / (0.1f * 0.1f);
  float albedo = 1.0f / (0.08f * 0.08f);
  float normal = 1.0f / (0.8f * 0.8f);
  float luminance = 1.0f / (2.5f * 2.5f);
};

/// Returns how much the guides of two pixels differ. `depth_step` is the difference in depth, in
/// mm, that does not count as an edge.
HOST_DEVICE float unlikeness(const Steering& p, const Steering& q, float depth_step,
                             const DenoiseTuning& tuning) {
  const float both = min(p.opacity, q.opacity);
  return tuning.opacity * squared(p.opacity - q.opacity) +
         tuning.albedo * squared(p.albedo - q.albedo) +
         tuning.normal * squared(p.normal - q.normal) +
         both * squared((p.depth - q.depth) / depth_step);
}

/// Returns how much the luminance of the picture steers a pass with taps `stride` apart. Before
/// neighbours have been averaged, a single bright path looks like a detail and would be preserved.
HOST_DEVICE float luminance_trust(std::int32_t stride) {
  return stride == 1 ? 0.0f : stride == 2 ? 0.1f : stride == 4 ? 0.5f : 1.0f;
}

/// Returns the difference in depth, in mm, between two pixels `distance` apart that does not count
/// as an edge: one voxel plus the `slope` of the surface (mm per pixel).
HOST_DEVICE float depth_step(float voxel, float slope, float distance) {
  return voxel + slope * distance;
}

/// Returns the weight of pixel q in the sum for pixel p. `trust` comes from luminance_trust().
HOST_DEVICE float tap_weight(const Smoothed& p, float variance, float trust, const Steering& at_p,
                             float slope, const Smoothed& q, const Steering& at_q, float spline,
                             float distance, float voxel) {
  const DenoiseTuning tuning;
  const float apart = unlikeness(at_p, at_q, depth_step(voxel, slope, distance), tuning) +
                      trust * tuning.luminance * squared(luminance(p.mean) - luminance(q.mean)) /
                          (variance + 1e-8f);
  return spline * at_q.takes_part * falloff(apart);
}

/// Returns the smaller of the steps in depth to the two sides of a pixel, which is the slope of its
/// surface.
HOST_DEVICE float slope_of(float before, float here, float after) {
  return min(fabsf(here - before), fabsf(after - here));
}

/// The contribution of one pixel to the two means that decide the blend. It uses luminance,
/// weighted by about the square of the tone curve's slope, because the error is that of the picture
/// on the screen.
struct Gain {
  float less_noise;  ///< d (d - F_d)
  float change;      ///< (F - M)^2
};

HOST_DEVICE Gain gain_of(const Smoothed& raw, const Smoothed& filtered) {
  const float shown = 1.0f / (bounded(luminance(filtered.mean), 0.0f, 1.0f) + 0.02f);
  return {shown * raw.deviation * (raw.deviation - filtered.deviation),
          shown * squared(luminance(filtered.mean) - luminance(raw.mean))};
}

HOST_DEVICE float share_of_filtered(const Gain& sum) {
  if (!(sum.change > 0.0f)) return 0.0f;
  return bounded(sum.less_noise / sum.change, 0.0f, 1.0f);
}

/// Edge in pixels of the tiles over which gains are summed.
inline constexpr std::uint32_t kGainTile = 16;

struct GainsView {
  const Gain* tiles;  ///< rows from the top
  std::uint32_t across, down;
};

/// Returns the gain at a pixel by bilinear interpolation between the centres of the four nearest
/// tiles, so that tile borders are invisible.
HOST_DEVICE Gain gain_around(const GainsView& gains, std::uint32_t x, std::uint32_t y) {
  const float u = bounded((static_cast<float>(x) + 0.5f) / kGainTile - 0.5f, 0.0f,
                          static_cast<float>(gains.across - 1));
  const float v = bounded((static_cast<float>(y) + 0.5f) / kGainTile - 0.5f, 0.0f,
                          static_cast<float>(gains.down - 1));
  const auto x0 = static_cast<std::uint32_t>(u), y0 = static_cast<std::uint32_t>(v);
  const std::uint32_t x1 = min(x0 + 1, gains.across - 1), y1 = min(y0 + 1, gains.down - 1);
  const float wx = u - static_cast<float>(x0), wy = v - static_cast<float>(y0);
  Gain sum{0.0f, 0.0f};
  const auto add = [&](std::uint32_t i, std::uint32_t j, float weight) {
    const Gain& g = gains.tiles[i + gains.across * j];
    sum.less_noise += weight * g.less_noise;
    sum.change += weight * g.change;
  };
  add(x0, y0, (1.0f - wx) * (1.0f - wy));
  add(x1, y0, wx * (1.0f - wy));
  add(x0, y1, (1.0f - wx) * wy);
  add(x1, y1, wx * wy);
  return sum;
}

/// Returns the blend of raw and filtered colour. If `share` is 0, it is exactly the raw colour.
HOST_DEVICE Float3 blended(Float3 raw, Float3 filtered, float share) {
  if (!(share > 0.0f)) return raw;
  if (!is_finite(raw)) return filtered;
  return raw + (filtered - raw) * share;
}

/// A picture whose estimated error (film/error.h) is at most this is not denoised, so that a
/// converged picture is the raw one.
inline constexpr double kNeverDenoised = 0.01;
/// Above this error, the filtered picture has its full share. Between the two limits the share
/// falls gradually, so that no step is visible.
inline constexpr double kFullyDenoised = 0.03;

/// Returns the factor for the share of the filtered picture. `error` is that of the raw picture, or
/// infinite if unknown. The squared error is convex in the share, so a share below the optimum
/// never makes the picture worse than the raw one.
inline float denoiser_fade(double error) {
  const double x = (error - kNeverDenoised) / (kFullyDenoised - kNeverDenoised);
  return static_cast<float>(x > 1 ? 1 : x > 0 ? x : 0);
}

/// Returns whether a pixel is smoothed and contributes to others. This requires that matter is
/// visible through it, that it shows no slice, and that at least one of its samples was finite.
HOST_DEVICE bool takes_part(const ConstFilmView& film, std::uint64_t pixel, std::uint64_t samples,
                            const Guides& guides) {
  const std::uint32_t state = film.state[pixel];
  if ((state & kShowsSlice) != 0) return false;
  if ((state & kHitMedium) == 0 && !(guides.opacity > 0.0f)) return false;
  const std::uint32_t dropped = (state & kDroppedMask) + (state >> 15 & kDroppedMask);
  return dropped < samples;
}

/// Estimates the deviation of a pixel of one sample, which has no halves. The difference from the
/// neighbour whose guides are most similar replaces the difference of the halves.
struct NeighbourDeviation {
  float value = 0.0f;
  float apart = 3.4e38f;

  HOST_DEVICE void offer(const Smoothed& p, const Steering& at_p, const Smoothed& q,
                         const Steering& at_q, float voxel) {
    constexpr float kHalfRoot = 0.70710678f;
    const float here = unlikeness(at_p, at_q, depth_step(voxel, 0.0f, 1.0f), {});
    if (!(at_q.takes_part > 0.0f) || !(here < apart)) return;
    apart = here;
    value = kHalfRoot * (luminance(p.mean) - luminance(q.mean));
  }
};

}  // namespace diaphane::render
