#pragma once

#include <cstdint>

#include "renderd/math/vector.h"

// The accumulated picture. A launch sums its samples of a pixel in fp32 (a PixelBatch) and adds
// them once to an fp64 sum, because an fp32 running mean of a sparse signal is off by 2.4% at 1e7
// samples. The two halves, the even and the odd samples, are independent pictures. Their difference
// shows how far the picture is from the converged one.

namespace diaphane::render {

/// The contribution of one launch to a pixel.
struct PixelBatch {
  Float3 even{}, odd{};            ///< sums over the even and over the odd samples
  std::uint32_t dropped_even = 0;  ///< samples that were not finite and are not in the sums
  std::uint32_t dropped_odd = 0;
  bool hit_medium = false;
  bool hit_slice = false;

  /// Adds a sample. `sample` is its number since the film was cleared, not its number in the random
  /// stream. `met` says that it hit matter or a slice, `slice` that it shows a slice.
  HOST_DEVICE void add(Float3 radiance, bool met, std::uint64_t sample, bool slice = false) {
    hit_medium |= met;
    hit_slice |= slice;
    const bool is_odd = (sample & 1) != 0;
    if (!is_finite(radiance)) {
      (is_odd ? dropped_odd : dropped_even) += 1;
      return;
    }
    (is_odd ? odd : even) += radiance;
  }
};

/// Three arrays over the pixels, rows from the top, 40 bytes per pixel. The sum needs fp64. For the
/// difference of the halves fp32 suffices, because it is noise.
struct FilmView {
  double* sum;           ///< 3 per pixel: even + odd
  float* difference;     ///< 3 per pixel: even - odd
  std::uint32_t* state;  ///< bit 31: hit matter; bit 30: shows a slice; bits 0-14 and 15-29:
                         ///< dropped even and odd samples, saturating
};
struct ConstFilmView {
  const double* sum;
  const float* difference;
  const std::uint32_t* state;
};
inline constexpr std::uint32_t kHitMedium = 1u << 31;
/// Set if any sample of the pixel shows a slice, so that the pixel is never denoised.
inline constexpr std::uint32_t kShowsSlice = 1u << 30;
inline constexpr std::uint32_t kDroppedMask = 0x7fff;

HOST_DEVICE void fold(const FilmView& film, std::uint64_t pixel, const PixelBatch& batch) {
  const Float3 s = batch.even + batch.odd, d = batch.even - batch.odd;
  double* sum = film.sum + 3 * pixel;
  float* difference = film.difference + 3 * pixel;
  sum[0] += static_cast<double>(s.x);
  sum[1] += static_cast<double>(s.y);
  sum[2] += static_cast<double>(s.z);
  difference[0] += d.x;
  difference[1] += d.y;
  difference[2] += d.z;
  if (batch.hit_medium || batch.hit_slice || batch.dropped_even != 0 || batch.dropped_odd != 0) {
    std::uint32_t state = film.state[pixel];
    const std::uint32_t even = min((state & kDroppedMask) + batch.dropped_even, kDroppedMask);
    const std::uint32_t odd = min((state >> 15 & kDroppedMask) + batch.dropped_odd, kDroppedMask);
    film.state[pixel] = (state & (kHitMedium | kShowsSlice)) |
                        (batch.hit_medium ? kHitMedium : 0u) |
                        (batch.hit_slice ? kShowsSlice : 0u) | even | odd << 15;
  }
}

/// The estimate of a pixel, and half the difference of its two halves, scaled so that the expected
/// value of its square is the variance of the estimate.
struct PixelEstimate {
  Float3 mean;
  Float3 deviation;
  bool hit_medium;
};

HOST_DEVICE float scaled_difference(double sum, float difference, double to_even, double to_odd) {
  return static_cast<float>((sum + static_cast<double>(difference)) * to_even -
                            (sum - static_cast<double>(difference)) * to_odd);
}

/// Returns the estimate of a pixel. `samples` is per pixel and includes dropped samples.
/// `deviation` is 0 unless both halves have a sample.
HOST_DEVICE PixelEstimate estimate_of(const ConstFilmView& film, std::uint64_t pixel,
                                      std::uint64_t samples) {
  const std::uint32_t state = film.state[pixel];
  const std::uint64_t odd_drawn = samples / 2, even_drawn = samples - odd_drawn;
  const double even = static_cast<double>(even_drawn - (state & kDroppedMask));
  const double odd = static_cast<double>(odd_drawn - (state >> 15 & kDroppedMask));
  const double count = even + odd;
  PixelEstimate e{{0, 0, 0}, {0, 0, 0}, (state & kHitMedium) != 0};
  if (!(count > 0)) return e;
  const double* s = film.sum + 3 * pixel;
  const float* d = film.difference + 3 * pixel;
  const double per_sample = 1.0 / count;
  e.mean = {static_cast<float>(s[0] * per_sample), static_cast<float>(s[1] * per_sample),
            static_cast<float>(s[2] * per_sample)};
  if (even > 0 && odd > 0) {
    // The scaled deviation is (A - B) sqrt(a b) / (a + b) for halves A and B of a and b samples.
    const double scale = sqrt(even * odd) * per_sample;
    const double to_even = scale * 0.5 / even, to_odd = scale * 0.5 / odd;
    e.deviation = {scaled_difference(s[0], d[0], to_even, to_odd),
                   scaled_difference(s[1], d[1], to_even, to_odd),
                   scaled_difference(s[2], d[2], to_even, to_odd)};
  }
  return e;
}

}  // namespace diaphane::render
