#pragma once

#include <cstdint>
#include <vector>

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
// halves (film.h: E[d^2] = Var[m]), (tone(m + d) - tone(m - d)) / 2 stands for tone(m) -
// tone(truth).

namespace diaphane::render {

inline constexpr std::uint32_t kTileSize =
    16;  ///< pixels; the error is known per tile of this edge

/// Histogram of radiance for the percentile: 16 steps an octave from 2^-32 to 2^32; a step is 4.4%.
inline constexpr std::uint32_t kWhiteBins = 1024;

HOST_DEVICE std::uint32_t white_bin(float radiance) {
  if (!(radiance > 0x1p-32f)) return 0;
  const float bin = (log2f(radiance) + 32.0f) * 16.0f;
  return smaller(static_cast<std::uint32_t>(smaller(bin, 1e6f)), kWhiteBins - 1);
}

/// The value below which 99% of the counts lie; 1 when there are none or all are black.
float white_from_histogram(const std::uint64_t (&counts)[kWhiteBins]);

HOST_DEVICE float squared_error(float mean, float deviation, float inverse_white) {
  const float difference =
      0.5f * (tone((mean + deviation) * inverse_white) - tone((mean - deviation) * inverse_white));
  return difference * difference;
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
  /// Of the whole picture: infinity below two samples, 0 when no pixel meets contents.
  double error = 0;
};

/// sqrt of the mean over the tiles' pixels and colours.
double total_error(const std::vector<TileError>& tiles, std::uint64_t samples);

/// On the host, one thread.
ErrorMap estimate_error(const ConstFilmView& film, std::uint32_t width, std::uint32_t height,
                        std::uint64_t samples);

}  // namespace diaphane::render
