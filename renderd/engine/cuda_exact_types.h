#pragma once

#include "renderd/engine/cuda_trace_types.h"
#include "renderd/kernel/walk.h"

// What the kernels of the exact walk hand each other. A launch takes a number of items, each one
// sample of one pixel: kernel 1 walks the camera rays and notes where they collide, kernel 2 walks
// from there to the lights, kernel 3 adds up each item and folds it into the film.

namespace diaphane::render::cuda {

/// Pixels of a tile, whose items lie side by side: 8 x 4, one a lane.
inline constexpr std::uint32_t kTileWidth = 8, kTileHeight = 4, kTilePixels = 32;

/// How a stripe is divided into tiles: all of the first sample, then all of the second, ...
struct TileGrid {
  std::uint32_t across, down;  ///< tiles of one sample
  HOST_DEVICE std::uint32_t per_sample() const { return across * down; }
};
HOST_DEVICE TileGrid tiles_of(std::uint32_t width, std::uint32_t height, const Stripe& stripe) {
  const std::uint32_t rows = smaller(stripe.rows, height - stripe.first_row);
  return {(width + kTileWidth - 1) / kTileWidth, (rows + kTileHeight - 1) / kTileHeight};
}

/// The part of a picture that an item is of.
struct ItemPlace {
  std::uint32_t x, y;    ///< the pixel: may lie outside the picture
  std::uint64_t sample;  ///< of the film
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
  Float3 origin;     ///< of the camera ray, in voxel indices
  Float3 direction;  ///< voxels per mm
  Float3 radiance;   ///< what is seen behind the matter, through it
  Span span;         ///< where matter may be met, mm
  /// 6 bits a kind: how many strata have a hit, always the first ones. Bit 30: the ray met matter
  /// or a slice, bit 31: it shows a slice.
  std::uint32_t hits;

  HOST_DEVICE std::int32_t hits_of(int kind) const {
    return static_cast<std::int32_t>(hits >> 6 * kind & 63u);
  }
};
inline constexpr std::uint32_t kItemMet = 1u << 30, kItemShowsSlice = 1u << 31;

/// A collision of a camera ray. Kernel 1: in which cell and how deep, kernel 2: its light.
struct alignas(16) HitRecord {
  /// mm along the ray, where it enters and leaves the cell, and the optical depth from there to the
  /// hit. Later red, green and blue.
  float a, b, c;
  std::uint32_t slot;  ///< item * 32 + stratum, counted through all kinds
};

/// Where a tile's hits begin among all: of those that look for light, and of those that go on.
struct TileHits {
  std::uint32_t light, onwards;
};

enum ExactCounter : int {
  kLightHits,    ///< there are so many
  kOnwardsHits,  ///< so many, from the end of the space for hits
  kLightTaken,   ///< handed out to warps of kernel 2
  kExactCounters = 4
};

/// Working memory of a launch.
struct ExactScratch {
  ExactItem* items;
  TileHits* tiles;
  HitRecord* hits;  ///< light from the first on, onwards from `onwards` on
  /// A hit's own light, beside each of `hits`; null where the scene's matter does not glow,
  /// whatever the kernel has compiled in.
  Float4* glow;
  std::uint32_t* counters;  ///< kExactCounters
  std::uint32_t onwards;
};

}  // namespace diaphane::render::cuda
