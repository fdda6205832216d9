#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "renderd/film/canvas.h"
#include "renderd/film/film.h"
#include "renderd/film/guides.h"

// Data types for several devices that render one picture (thesis 5.1.2, 8.2): the share that one
// device renders, and the part of its film that it hands over.

namespace diaphane::render {

/// Bands begin at multiples of this number of rows, a multiple of every engine's unit of work.
inline constexpr std::uint32_t kShareRows = 16;

/// The share of a picture that one of several devices renders: some of the rows and some of the
/// samples. The default is the whole picture.
struct Share {
  std::uint32_t first_row = 0;              ///< a multiple of kShareRows
  std::uint32_t last_row = kLongestCanvas;  ///< one past the last row; also a multiple of
                                            ///< kShareRows, or the picture's height
  std::uint32_t part = 0, parts = 1;        ///< index and number of devices (SampleNumbers)
  std::uint64_t sequence = 0;               ///< below 2^20; different sequences are independent

  bool operator==(const Share&) const = default;
};

/// Distance between the starts of two sequences, far more than the samples of any one picture.
inline constexpr std::uint64_t kSequenceSamples = std::uint64_t{1} << 40;

/// The accumulated samples of a pixel, packed into 10 bytes.
///
/// `mean` is the mean of the finite samples. It has 6 bits of exponent (2^-40 to 2^23), 10 bits of
/// mantissa, and no sign, because radiance is not negative. It is rounded to nearest, so its
/// relative error is at most 2^-11. On the display this is x^(1/2.2) 2^-11 / 2.2 < 2.3e-4 of white
/// and 1.3e-4 in the root mean square, which is invisible in a picture that is converged to 1%. The
/// roundings of different parts are independent, so merging reduces the error.
///
/// `half` is half the difference of the means of the two halves divided by twice the mean, within
/// [-1, 1]: a sign, 5 bits of exponent and 2 bits of mantissa. It gives the noise of one pixel to
/// 9% and that of a picture to 0.2%.
struct alignas(2) PackedPixel {
  std::uint16_t mean[3];
  std::uint8_t half[3];
  std::uint8_t
      state;  ///< bit 7: hit matter; bit 6: slice; bits 0-2 and 3-5: dropped even and odd samples

  bool operator==(const PackedPixel&) const = default;
};

/// The pixels of a part that remain in the memory of a device.
struct PixelsOnDevice {
  virtual ~PixelsOnDevice() = default;
};

/// The samples that a band of rows accumulated since its previous part was taken.
struct FilmPart {
  std::uint32_t width = 0;
  std::uint32_t first_row = 0, rows = 0;
  std::uint64_t samples = 0;  ///< per pixel; even, with the same number in both halves
  std::vector<PackedPixel> pixels;
  /// The guides of the same pixels, or empty. Only a band brings guides, and only with its first
  /// samples. For a whole picture, the receiving device records its own.
  std::vector<PackedGuides> guides = {};
  /// Replaces `pixels` and `guides` between engines of the same kind in this process.
  std::shared_ptr<const PixelsOnDevice> on_device = nullptr;
};

/// Returns whether [first_row, last_row) can be a share of a picture of `height` rows.
inline bool is_band(std::uint32_t first_row, std::uint32_t last_row, std::uint32_t height) {
  return first_row % kShareRows == 0 && first_row < last_row && last_row <= height &&
         (last_row % kShareRows == 0 || last_row == height);
}
/// Returns whether `part` can belong to a picture of this size.
inline bool fits(const FilmPart& part, Canvas size) {
  return part.width == size.width && part.rows <= size.height &&
         is_band(part.first_row, part.first_row + part.rows, size.height) &&
         part.samples % 2 == 0 &&
         (part.on_device || part.pixels.size() == std::size_t{part.width} * part.rows) &&
         (part.guides.empty() || part.guides.size() == std::size_t{part.width} * part.rows);
}

/// Packs x >= 0 as PackedPixel::mean. Below 2^-40 the result is 0, and from 2^24 on it is the
/// largest number.
HOST_DEVICE std::uint16_t pack_mean(float x) {
  union Bits {
    float f;
    std::uint32_t u;
  } b{x};
  constexpr std::uint32_t kBase = (127u - 40u) << 23;
  if (!(x >= 0x1p-40f)) return 0;
  const std::uint32_t rounded = b.u + 0xfffu + (b.u >> 13 & 1u);
  const std::uint32_t steps = ((rounded - kBase) >> 13) + 1;  // 0 is reserved for zero
  return static_cast<std::uint16_t>(min(steps, 0xffffu));
}
HOST_DEVICE float unpack_mean(std::uint16_t packed) {
  if (packed == 0) return 0.0f;
  union Bits {
    std::uint32_t u;
    float f;
  } b{((std::uint32_t{packed} - 1u) << 13) + ((127u - 40u) << 23)};
  return b.f;
}

/// Packs x in [-1, 1] as PackedPixel::half. The result is 0 if |x| is below 2^-31.
HOST_DEVICE std::uint8_t pack_half(float x) {
  union Bits {
    float f;
    std::uint32_t u;
  } b{x};
  const std::uint32_t sign = b.u >> 24 & 0x80u;
  b.u &= 0x7fffffffu;
  constexpr std::uint32_t kBase = (127u - 31u) << 23;
  if (!(b.f >= 0x1p-31f)) return 0;
  const std::uint32_t rounded = b.u + 0xfffffu + (b.u >> 21 & 1u);
  const std::uint32_t steps = ((rounded - kBase) >> 21) + 1;
  return static_cast<std::uint8_t>(sign | min(steps, 0x7fu));
}
HOST_DEVICE float unpack_half(std::uint8_t packed) {
  const std::uint32_t steps = packed & 0x7fu;
  if (steps == 0) return 0.0f;
  union Bits {
    std::uint32_t u;
    float f;
  } b{((steps - 1u) << 21) + ((127u - 31u) << 23)};
  return (packed & 0x80u) != 0 ? -b.f : b.f;
}

HOST_DEVICE std::uint8_t pack_relative_half(double even, double odd, float mean) {
  if (!(mean > 0.0f)) return 0;
  const float r = static_cast<float>((even - odd) / (4.0 * static_cast<double>(mean)));
  return pack_half(min(max(r, -1.0f), 1.0f));
}

/// Packs a pixel of `samples` samples, which is an even number.
HOST_DEVICE PackedPixel pack_pixel(const ConstFilmView& film, std::uint64_t pixel,
                                   std::uint64_t samples) {
  const std::uint32_t state = film.state[pixel];
  const std::uint32_t dropped_even = state & kDroppedMask, dropped_odd = state >> 15 & kDroppedMask;
  PackedPixel p{};
  p.state = static_cast<std::uint8_t>(((state & kHitMedium) != 0 ? 0x80u : 0u) |
                                      ((state & kShowsSlice) != 0 ? 0x40u : 0u) |
                                      min(dropped_even, 7u) | min(dropped_odd, 7u) << 3);
  const std::uint64_t pairs = samples / 2;
  const double a = static_cast<double>(pairs) - dropped_even;
  const double b = static_cast<double>(pairs) - dropped_odd;
  if (!(a + b > 0)) return p;
  const double* s = film.sum + 3 * pixel;
  const float* d = film.difference + 3 * pixel;
  for (int c = 0; c < 3; ++c) {
    const double difference = static_cast<double>(d[c]);
    const float mean = static_cast<float>(s[c] / (a + b));
    p.mean[c] = pack_mean(mean);
    if (a > 0 && b > 0) {
      p.half[c] =
          pack_relative_half(0.5 * (s[c] + difference) / a, 0.5 * (s[c] - difference) / b, mean);
    }
  }
  return p;
}

/// Adds `p`, which has `samples` samples, to a pixel. If more than 7 samples of a half were
/// dropped, the weight of `p` is slightly too high, but its mean is right.
HOST_DEVICE void merge_pixel(const FilmView& film, std::uint64_t pixel, const PackedPixel& p,
                             std::uint64_t samples) {
  const std::uint32_t dropped_even = p.state & 7u, dropped_odd = p.state >> 3 & 7u;
  const std::uint64_t pairs = samples / 2;
  const double n = static_cast<double>(pairs);
  const double a = n > dropped_even ? n - dropped_even : 0.0,
               b = n > dropped_odd ? n - dropped_odd : 0.0;
  double* s = film.sum + 3 * pixel;
  float* d = film.difference + 3 * pixel;
  for (int c = 0; c < 3; ++c) {
    const double mean = static_cast<double>(unpack_mean(p.mean[c]));
    const double apart = 4.0 * mean * static_cast<double>(unpack_half(p.half[c]));
    s[c] += (a + b) * mean;
    d[c] += static_cast<float>((a - b) * mean + (a + b > 0 ? 2.0 * a * b / (a + b) * apart : 0.0));
  }
  const std::uint32_t state = film.state[pixel];
  const std::uint32_t even = min((state & kDroppedMask) + dropped_even, kDroppedMask);
  const std::uint32_t odd = min((state >> 15 & kDroppedMask) + dropped_odd, kDroppedMask);
  film.state[pixel] = (state & (kHitMedium | kShowsSlice)) |
                      ((p.state & 0x80u) != 0 ? kHitMedium : 0u) |
                      ((p.state & 0x40u) != 0 ? kShowsSlice : 0u) | even | odd << 15;
}

}  // namespace diaphane::render
