#pragma once

#include "renderd/engine/cuda/trace_types.h"
#include "renderd/kernel/walk.h"

// The data that the kernels of the exact walk pass to each other. A launch processes a number of
// items; an item is one sample of one pixel. Kernel 1 walks the camera rays and records where they
// collide. Kernel 2 walks rays from the collisions to the lights. With Feature::kBounces, the
// indirect kernel then continues paths from collisions. Kernel 3 sums up each item and adds it to
// the film.

namespace diaphane::render::cuda {

/// The size of a tile, 8 x 4 pixels. Its items are contiguous, one per lane.
inline constexpr std::uint32_t kTileWidth = 8, kTileHeight = 4, kTilePixels = 32;

/// The division of a stripe into tiles: all tiles of the first sample, then all of the second, and
/// so on.
struct TileGrid {
  std::uint32_t across, down;  ///< tiles of one sample
  HOST_DEVICE std::uint32_t per_sample() const { return across * down; }
};
HOST_DEVICE TileGrid tiles_of(std::uint32_t width, std::uint32_t height, const Stripe& stripe) {
  const std::uint32_t rows = min(stripe.rows, height - stripe.first_row);
  return {(width + kTileWidth - 1) / kTileWidth, (rows + kTileHeight - 1) / kTileHeight};
}

/// The pixel and the sample of an item.
struct ItemPlace {
  std::uint32_t x, y;    ///< the pixel, which may lie outside the picture
  std::uint64_t sample;  ///< number of the sample in the film
};
HOST_DEVICE ItemPlace place_of(const TileGrid& tiles, const Stripe& stripe, std::uint32_t tile,
                               std::uint32_t lane) {
  const std::uint32_t sample = tile / tiles.per_sample(), t = tile - sample * tiles.per_sample();
  const std::uint32_t row = t / tiles.across, column = t - row * tiles.across;
  return {column * kTileWidth + lane % kTileWidth,
          stripe.first_row + row * kTileHeight + lane / kTileWidth, stripe.film_sample + sample};
}

/// One sample of one pixel, after kernel 1.
struct alignas(16) ExactItem {
  Float3 origin;     ///< origin of the camera ray, in voxel indices
  Float3 direction;  ///< voxels per mm
  Float3 radiance;   ///< radiance of the background that reaches the camera
  Span span;         ///< range of the ray that may contain matter, mm
  /// Number of strata with a hit, in 6 bits per kind; hits are always in the first strata. Bit 30
  /// is set if the ray hit matter or a slice, and bit 31 if it shows a slice.
  std::uint32_t hits;

  HOST_DEVICE std::int32_t hits_of(int kind) const {
    return static_cast<std::int32_t>(hits >> 6 * kind & 63u);
  }
};
inline constexpr std::uint32_t kItemMet = 1u << 30, kItemShowsSlice = 1u << 31;

/// A collision of a camera ray. Kernel 1 writes its position, and the next kernels its light.
struct alignas(16) HitRecord {
  /// First the distances at which the ray enters and leaves the cell (mm), and the optical depth
  /// from the entry to the hit. Later red, green and blue.
  float a, b, c;
  std::uint32_t slot;  ///< item * kMostHits + stratum; strata are counted across all kinds
};

/// The indices of a tile's first hit that looks for light, and of its first hit from which a path
/// continues.
struct TileHits {
  std::uint32_t light, indirect;
};

enum ExactCounter : int {
  kLightHits,     ///< number of hits that look for light
  kIndirectHits,  ///< number of continued hits, stored from `indirect` on
  kLightTaken,    ///< hits that warps of kernel 2 have taken
  kExactCounters = 4
};

/// The working memory of a launch.
struct ExactScratch {
  ExactItem* items;
  TileHits* tiles;
  HitRecord* hits;  ///< hits that look for light first, continued hits from `indirect` on
  /// The light that each of the `hits` emits itself. Null if the scene has no emission, even if the
  /// kernel supports it.
  Float4* glow;
  std::uint32_t* counters;  ///< indexed by ExactCounter
  std::uint32_t indirect;
};

}  // namespace diaphane::render::cuda
