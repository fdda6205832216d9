#include "renderd/film/error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diaphane::render {

namespace {

/// Returns the value below which 99% of the counted colours lie, assuming an even spread within
/// each bin. Returns 0 if nothing was counted or at least 99% of the colours are black.
float percentile(const std::uint64_t* counts) {
  std::uint64_t total = 0;
  for (std::uint32_t bin = 0; bin < kWhiteBins; ++bin) total += counts[bin];
  const double rank = 0.99 * static_cast<double>(total);
  double below = 0;
  for (std::uint32_t bin = 0; bin < kWhiteBins; ++bin) {
    const double here = static_cast<double>(counts[bin]);
    if (here > 0 && below + here >= rank) {
      if (bin == 0) return 0.0f;
      // Each octave is divided into 16 equal steps.
      const float part = static_cast<float>((rank - below) / here);
      return std::ldexp(1.0f + (static_cast<float>(bin % 16) + part) / 16.0f,
                        static_cast<int>(bin / 16) - 32);
    }
    below += here;
  }
  return 0.0f;
}

}  // namespace

float white_from_histogram(const WhiteHistogram& histogram) {
  const float mean = percentile(histogram.counts);
  const float half = percentile(histogram.counts + kWhiteBins);
  if (!(mean > 0.0f)) return 1.0f;
  // A larger ratio does not predict the remaining step, so it counts only up to a factor of two.
  return mean / std::clamp(half / mean, 0.5f, 2.0f);
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
    if ((film.state[pixel] & kHitMedium) == 0) continue;
    const WhiteEntries entries = white_entries(estimate_of(film, pixel, samples), pixel);
    for (const std::uint32_t i : entries.of) ++histogram.counts[i];
  }
}

TileError tile_error(const ConstFilmView& film, Canvas size, std::uint32_t tile_x,
                     std::uint32_t tile_y, std::uint64_t samples, float white, ToneCurve curve) {
  TileError tile;
  const std::uint32_t end_x = std::min((tile_x + 1) * kTileSize, size.width);
  const std::uint32_t end_y = std::min((tile_y + 1) * kTileSize, size.height);
  for (std::uint32_t y = tile_y * kTileSize; y < end_y; ++y) {
    for (std::uint32_t x = tile_x * kTileSize; x < end_x; ++x) {
      const std::uint64_t pixel = x + std::uint64_t{size.width} * y;
      if ((film.state[pixel] & kHitMedium) == 0) continue;
      tile.squared += squared_error(estimate_of(film, pixel, samples), 1.0f / white, curve);
      ++tile.pixels;
    }
  }
  return tile;
}

}  // namespace diaphane::render
