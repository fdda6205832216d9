#include "renderd/film/error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diaphane::render {

float white_from_histogram(const WhiteHistogram& histogram) {
  std::uint64_t total = 0;
  for (std::uint64_t n : histogram.counts) total += n;
  std::uint64_t below = 0;
  for (std::uint32_t bin = 0; bin < kWhiteBins; ++bin) {
    below += histogram.counts[bin];
    if (below > 0 && static_cast<double>(below) >= 0.99 * static_cast<double>(total)) {
      if (bin == 0) break;
      // The middle of the bin: 16 equal steps within an octave.
      return std::ldexp(1.0f + (static_cast<float>(bin % 16) + 0.5f) / 16.0f,
                        static_cast<int>(bin / 16) - 32);
    }
  }
  return 1.0f;
}

double total_error(const std::vector<TileError>& tiles, std::uint64_t samples) {
  if (samples < 2) return std::numeric_limits<double>::infinity();
  double squared = 0;
  std::uint64_t pixels = 0;
  for (const TileError& tile : tiles) {
    squared += static_cast<double>(tile.squared);
    pixels += tile.pixels;
  }
  return pixels == 0 ? 0 : std::sqrt(squared / (3.0 * static_cast<double>(pixels)));
}

void count_white(const ConstFilmView& film, std::uint64_t first, std::uint64_t last,
                 std::uint64_t samples, WhiteHistogram& histogram) {
  for (std::uint64_t pixel = first; pixel < last; ++pixel) {
    if ((film.state[pixel] & kMetMatter) == 0) continue;
    const Float3 mean = estimate_of(film, pixel, samples).mean;
    ++histogram.counts[white_bin(mean.x)];
    ++histogram.counts[white_bin(mean.y)];
    ++histogram.counts[white_bin(mean.z)];
  }
}

TileError tile_error(const ConstFilmView& film, Canvas size, std::uint32_t tile_x,
                     std::uint32_t tile_y, std::uint64_t samples, float white) {
  TileError tile;
  const std::uint32_t end_x = std::min((tile_x + 1) * kTileSize, size.width);
  const std::uint32_t end_y = std::min((tile_y + 1) * kTileSize, size.height);
  for (std::uint32_t y = tile_y * kTileSize; y < end_y; ++y) {
    for (std::uint32_t x = tile_x * kTileSize; x < end_x; ++x) {
      const std::uint64_t pixel = x + std::uint64_t{size.width} * y;
      if ((film.state[pixel] & kMetMatter) == 0) continue;
      tile.squared += squared_error(estimate_of(film, pixel, samples), 1.0f / white);
      ++tile.pixels;
    }
  }
  return tile;
}

}  // namespace diaphane::render
