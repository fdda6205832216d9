#pragma once

#include <cstdint>
#include <vector>

#include "renderd/film/canvas.h"
#include "renderd/film/film.h"
#include "renderd/film/tone.h"

// How far the accumulated picture is from the converged one, estimated without knowing that one.
//
// Definition: the root mean square, over the pixels whose samples met contents of the volume and
// over the three colours, of tone(x / white) - tone(truth / white), tone(x) = clip(x, 0,
// 1)^(1/2.2), white the 99th percentile of the picture's values over the same pixels. It does not
// depend on exposure, and a picture error of 0.05 is 5% of the way from black to white on the
// screen.
//
// Estimate: with m the mean of n samples and d the scaled half difference of its two independent
// halves (film.h: E[d^2] = Var[m]), the steps from tone(m) to tone(m + d) and to tone(m - d) stand
// for the one to tone(truth): the mean of their squares. That is
//   ((tone(m + d) - tone(m - d)) / 2)^2 + ((tone(m + d) + tone(m - d)) / 2 - tone(m))^2,
// half the variance of a displayed half, and beside it the square of the jackknife's bias: curve
// and clipping make noisy values too dark. Without the second term 17% of the error are missing
// where the truth is white. What both halves have as black is not seen by either: where light comes
// in less than one sample of a half, the estimate is too low.
//
// White: noise spreads the values, and so their percentile is too high, the more the fewer samples.
// The halves have twice the variance; what their percentile is above that of the mean, the mean's
// is above the truth's: the square of the one over the other.

namespace diaphane::render {

inline constexpr std::uint32_t kTileSize =
    16;  ///< pixels; the error is known per tile of this edge

/// Histogram of radiance for the percentile: 16 steps an octave from 2^-32 to 2^32, by the bits of
/// the float.
inline constexpr std::uint32_t kWhiteBins = 1024;

HOST_DEVICE std::uint32_t white_bin(float radiance) {
  union Bits {
    float f;
    std::uint32_t u;
  } const b{smaller(larger(radiance, 0x1p-32f), 0x1.fp31f)};
  return (b.u >> 19) - ((127u - 32u) << 4);
}

/// Of the pixels' means, and of one half of each: of one pixel the even samples', of the next the
/// odd ones'.
inline constexpr std::uint32_t kWhiteCounts = 2 * kWhiteBins;

struct WhiteHistogram {
  std::uint64_t counts[kWhiteCounts] = {};  ///< the means' bins, then the halves'
};

/// The counts of WhiteHistogram that a pixel which met contents adds one to, each.
struct WhiteEntries {
  std::uint32_t of[6];
};
HOST_DEVICE WhiteEntries white_entries(const PixelEstimate& e, std::uint64_t pixel) {
  const Float3 half = (pixel & 1) != 0 ? e.mean - e.deviation : e.mean + e.deviation;
  return {{white_bin(e.mean.x), white_bin(e.mean.y), white_bin(e.mean.z),
           kWhiteBins + white_bin(half.x), kWhiteBins + white_bin(half.y),
           kWhiteBins + white_bin(half.z)}};
}

/// Adds the pixels [first, last) that met contents, each with its three colours.
void count_white(const ConstFilmView& film, std::uint64_t first, std::uint64_t last,
                 std::uint64_t samples, WhiteHistogram& histogram);

/// The value below which 99% of the pixels' colours would lie without noise; 1 when there are none
/// or all are black.
float white_from_histogram(const WhiteHistogram& histogram);

HOST_DEVICE float squared_error(float mean, float deviation, float inverse_white) {
  const float at = tone(mean * inverse_white);
  const float up = tone((mean + deviation) * inverse_white) - at;
  const float down = at - tone((mean - deviation) * inverse_white);
  return 0.5f * (up * up + down * down);
}
/// Of one pixel, summed over the colours; divide by 3 for the mean.
HOST_DEVICE float squared_error(const PixelEstimate& e, float inverse_white) {
  return squared_error(e.mean.x, e.deviation.x, inverse_white) +
         squared_error(e.mean.y, e.deviation.y, inverse_white) +
         squared_error(e.mean.z, e.deviation.z, inverse_white);
}

struct TileError {
  float squared = 0;         ///< sum over the tile's counted pixels and colours
  std::uint32_t pixels = 0;  ///< counted: met contents
};

struct ErrorMap {
  std::uint32_t tiles_x = 0, tiles_y = 0;
  std::vector<TileError> tiles;  ///< rows from the top
  float white = 1;
};

/// On the host; one tile. An engine spreads the tiles over its threads.
TileError tile_error(const ConstFilmView& film, Canvas size, std::uint32_t tile_x,
                     std::uint32_t tile_y, std::uint64_t samples, float white);

/// Of the whole picture, sqrt of the mean over the tiles' pixels and colours: infinity below two
/// samples, 0 when no pixel meets contents.
double total_error(const std::vector<TileError>& tiles, std::uint64_t samples);

}  // namespace diaphane::render
