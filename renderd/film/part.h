#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "renderd/film/canvas.h"
#include "renderd/film/film.h"

// Several devices that make one picture (thesis 5.1.2, 8.2): what one of them is to render, and
// what it hands over.

namespace diaphane::render {

/// Bands of rows begin at multiples of it: a multiple of every engine's unit of work.
inline constexpr std::uint32_t kShareRows = 16;

/// What one of several devices renders of a picture: some of the rows and some of the samples. The
/// whole of it by default.
struct Share {
  std::uint32_t first_row = 0;              ///< a multiple of kShareRows
  std::uint32_t last_row = kLongestCanvas;  ///< one beyond; likewise, or the picture's height
  std::uint32_t part = 0, parts = 1;        ///< of the sequence (SampleNumbers)
  std::uint64_t sequence = 0;               ///< below 2^20: others are independent of it

  bool operator==(const Share&) const = default;
};

/// Far more samples than are ever drawn of one picture: where sequences begin.
inline constexpr std::uint64_t kSequenceSamples = std::uint64_t{1} << 40;

/// A pixel of some samples, packed: 10 bytes.
///
/// `mean` of the samples that were finite: without a sign (radiance has none), 6 bits of exponent
/// (2^-40 to 2^23) and 10 of mantissa, to nearest: at most 2^-11 of the value off. On the display
/// that is x^(1/2.2) 2^-11 / 2.2 < 2.3e-4 of white, 1.3e-4 in the root mean square, which a picture
/// that is converged to 1% does not show; parts' roundings are independent, so merging makes it
/// less.
///
/// `half` is half the distance of the two halves' means over twice the mean, within [-1, 1]: a
/// sign, 5 bits of exponent and 2 of mantissa. It tells how noisy a pixel is, to 9% one pixel and
/// to 0.2% over a picture.
struct alignas(2) PackedPixel {
  std::uint16_t mean[3];
  std::uint8_t half[3];
  std::uint8_t state;  ///< bit 7: met matter; bit 6: slice; 0-2, 3-5: dropped, even and odd

  bool operator==(const PackedPixel&) const = default;
};

/// Pixels that have stayed on a device.
struct PixelsOnDevice {
  virtual ~PixelsOnDevice() = default;
};

/// What was drawn of a band of rows since it was last taken.
struct FilmPart {
  std::uint32_t width = 0;
  std::uint32_t first_row = 0, rows = 0;
  std::uint64_t samples = 0;  ///< of each pixel; even: as many of one half as of the other
  std::vector<PackedPixel> pixels;
  /// Instead of `pixels`: for engines of the same kind in this process.
  std::shared_ptr<const PixelsOnDevice> on_device = nullptr;
};

/// Whether [first_row, last_row) can be a share of a picture of `height` rows.
inline bool is_band(std::uint32_t first_row, std::uint32_t last_row, std::uint32_t height) {
  return first_row % kShareRows == 0 && first_row < last_row && last_row <= height &&
         (last_row % kShareRows == 0 || last_row == height);
}
/// Whether `part` can be of a picture of this size.
inline bool fits(const FilmPart& part, Canvas size) {
  return part.width == size.width && part.rows <= size.height &&
         is_band(part.first_row, part.first_row + part.rows, size.height) &&
         part.samples % 2 == 0 &&
         (part.on_device || part.pixels.size() == std::size_t{part.width} * part.rows);
}

/// x >= 0 as PackedPixel::mean; below 2^-40 it is 0, beyond 2^24 the largest.
HOST_DEVICE std::uint16_t pack_mean(float x) {
  union Bits {
    float f;
    std::uint32_t u;
  } b{x};
  constexpr std::uint32_t kBase = (127u - 40u) << 23;
  if (!(x >= 0x1p-40f)) return 0;
  const std::uint32_t rounded = b.u + 0xfffu + (b.u >> 13 & 1u);
  const std::uint32_t steps = ((rounded - kBase) >> 13) + 1;  // 0 is kept for nothing
  return static_cast<std::uint16_t>(smaller(steps, 0xffffu));
}
HOST_DEVICE float unpack_mean(std::uint16_t packed) {
  if (packed == 0) return 0.0f;
  union Bits {
    std::uint32_t u;
    float f;
  } b{((std::uint32_t{packed} - 1u) << 13) + ((127u - 40u) << 23)};
  return b.f;
}

/// x in [-1, 1] as PackedPixel::half; nearer to 0 than 2^-31 it is 0.
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
  return static_cast<std::uint8_t>(sign | smaller(steps, 0x7fu));
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
  return pack_half(smaller(larger(r, -1.0f), 1.0f));
}

/// Of a pixel of `samples`, an even number.
HOST_DEVICE PackedPixel pack_pixel(const ConstFilmView& film, std::uint64_t pixel,
                                   std::uint64_t samples) {
  const std::uint32_t state = film.state[pixel];
  const std::uint32_t lost_even = state & kDroppedMask, lost_odd = state >> 15 & kDroppedMask;
  PackedPixel p{};
  p.state = static_cast<std::uint8_t>(((state & kMetMatter) != 0 ? 0x80u : 0u) |
                                      ((state & kShowsSlice) != 0 ? 0x40u : 0u) |
                                      smaller(lost_even, 7u) | smaller(lost_odd, 7u) << 3);
  const std::uint64_t pairs = samples / 2;
  const double a = static_cast<double>(pairs) - lost_even;
  const double b = static_cast<double>(pairs) - lost_odd;
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

/// Adds `p`, of `samples`, to a pixel. A pixel that dropped more than 7 samples of a half weighs a
/// little too much; its mean is right.
HOST_DEVICE void merge_pixel(const FilmView& film, std::uint64_t pixel, const PackedPixel& p,
                             std::uint64_t samples) {
  const std::uint32_t lost_even = p.state & 7u, lost_odd = p.state >> 3 & 7u;
  const std::uint64_t pairs = samples / 2;
  const double n = static_cast<double>(pairs);
  const double a = n > lost_even ? n - lost_even : 0.0, b = n > lost_odd ? n - lost_odd : 0.0;
  double* s = film.sum + 3 * pixel;
  float* d = film.difference + 3 * pixel;
  for (int c = 0; c < 3; ++c) {
    const double mean = static_cast<double>(unpack_mean(p.mean[c]));
    const double apart = 4.0 * mean * static_cast<double>(unpack_half(p.half[c]));
    s[c] += (a + b) * mean;
    d[c] += static_cast<float>((a - b) * mean + (a + b > 0 ? 2.0 * a * b / (a + b) * apart : 0.0));
  }
  const std::uint32_t state = film.state[pixel];
  const std::uint32_t even = smaller((state & kDroppedMask) + lost_even, kDroppedMask);
  const std::uint32_t odd = smaller((state >> 15 & kDroppedMask) + lost_odd, kDroppedMask);
  film.state[pixel] = (state & (kMetMatter | kShowsSlice)) |
                      ((p.state & 0x80u) != 0 ? kMetMatter : 0u) |
                      ((p.state & 0x40u) != 0 ? kShowsSlice : 0u) | even | odd << 15;
}

}  // namespace diaphane::render
