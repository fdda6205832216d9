#pragma once

#include <cstdint>
#include <vector>

#include "renderd/film/canvas.h"
#include "renderd/film/film.h"
#include "renderd/film/tone.h"

// Estimates how far the accumulated picture is from the converged one without knowing the latter.
//
// Definition: the error is the root mean square of tone(x / white) - tone(truth / white) over the
// three colours and over the pixels whose samples hit contents of the volume. Here tone(x) is the
// curve that the scene is displayed with (tone.h), and white is the 99th percentile of the values
// of the picture over the same pixels. The error does not depend on the exposure. An error of 0.05
// is 5% of the way from black to white on the screen.
//
// Estimate: let m be the mean of n samples and d the scaled half difference of its two independent
// halves (film.h: E[d^2] = Var[m]). The steps from tone(m) to tone(m + d) and to tone(m - d)
// replace the step to tone(truth). The mean of their squares is
//   ((tone(m + d) - tone(m - d)) / 2)^2 + ((tone(m + d) + tone(m - d)) / 2 - tone(m))^2.
// The first term is half the variance of a displayed half. The second is the square of the
// jackknife bias, because the curve and the clipping make noisy values too dark. Without the second
// term, 17% of the error is missing where the truth is white. Light that neither half has received
// yet is unknown to both, so where light arrives in less than one sample per half, the estimate is
// too low.
//
// White: noise spreads the values and so raises their percentile, the more so the fewer samples
// there are. The halves have twice the variance of the mean. Their percentile therefore exceeds
// that of the mean by as much as that of the mean exceeds that of the truth. The estimate is the
// square of the mean's percentile divided by that of the halves.

namespace diaphane::render {

/// Edge in pixels of the tiles for which errors are summed.
inline constexpr std::uint32_t kTileSize = 16;

/// Number of bins of the histogram of radiance that gives the percentile: 16 per octave from 2^-32
/// to 2^32. A bin comes from the bits of the float.
inline constexpr std::uint32_t kWhiteBins = 1024;

HOST_DEVICE std::uint32_t white_bin(float radiance) {
  union Bits {
    float f;
    std::uint32_t u;
  } const b{min(max(radiance, 0x1p-32f), 0x1.fp31f)};
  return (b.u >> 19) - ((127u - 32u) << 4);
}

/// Number of bins for the means of the pixels and for one half of each pixel, which alternates: the
/// even samples of one pixel, the odd samples of the next.
inline constexpr std::uint32_t kWhiteCounts = 2 * kWhiteBins;

struct WhiteHistogram {
  std::uint64_t counts[kWhiteCounts] = {};  ///< bins of the means, then bins of the halves
};

/// The indices of the six counts in WhiteHistogram that a pixel which hit contents increments.
struct WhiteEntries {
  std::uint32_t of[6];
};
HOST_DEVICE WhiteEntries white_entries(const PixelEstimate& e, std::uint64_t pixel) {
  const Float3 half = (pixel & 1) != 0 ? e.mean - e.deviation : e.mean + e.deviation;
  return {{white_bin(e.mean.x), white_bin(e.mean.y), white_bin(e.mean.z),
           kWhiteBins + white_bin(half.x), kWhiteBins + white_bin(half.y),
           kWhiteBins + white_bin(half.z)}};
}

/// Adds the colours of the pixels [first, last) that hit contents to `histogram`.
void count_white(const ConstFilmView& film, std::uint64_t first, std::uint64_t last,
                 std::uint64_t samples, WhiteHistogram& histogram);

/// Returns the value below which 99% of the colours of the pixels would lie without noise. Returns
/// 1 if there are no pixels or at least 99% of the colours are black.
float white_from_histogram(const WhiteHistogram& histogram);

HOST_DEVICE float squared_error(float mean, float deviation, float inverse_white, ToneCurve curve) {
  const float at = tone(mean * inverse_white, curve);
  const float up = tone((mean + deviation) * inverse_white, curve) - at;
  const float down = at - tone((mean - deviation) * inverse_white, curve);
  return 0.5f * (up * up + down * down);
}
/// Returns the squared error of one pixel, summed over its three colours.
HOST_DEVICE float squared_error(const PixelEstimate& e, float inverse_white, ToneCurve curve) {
  return squared_error(e.mean.x, e.deviation.x, inverse_white, curve) +
         squared_error(e.mean.y, e.deviation.y, inverse_white, curve) +
         squared_error(e.mean.z, e.deviation.z, inverse_white, curve);
}

struct TileError {
  float squared = 0;         ///< sum over the counted pixels of the tile and their colours
  std::uint32_t pixels = 0;  ///< counted pixels, which are those that hit contents
};

struct ErrorMap {
  std::uint32_t tiles_x = 0, tiles_y = 0;
  std::vector<TileError> tiles;  ///< rows from the top
  float white = 1;
};

/// Computes the error of one tile on the host. An engine distributes the tiles over its threads.
TileError tile_error(const ConstFilmView& film, Canvas size, std::uint32_t tile_x,
                     std::uint32_t tile_y, std::uint64_t samples, float white,
                     ToneCurve curve = ToneCurve::kLinear);

/// Returns the error of the whole picture: the square root of the mean over the counted pixels and
/// their colours. The error is infinite below two samples, and 0 if no pixel hits contents.
double total_error(const std::vector<TileError>& tiles, std::uint64_t samples);

}  // namespace diaphane::render
