#pragma once

#include <cstdint>
#include <vector>

#include "renderd/engine/thread_pool.h"
#include "renderd/film/canvas.h"
#include "renderd/film/film.h"
#include "renderd/film/guides.h"
#include "renderd/film/part.h"

namespace diaphane::render {

/// What the denoiser reads.
struct DenoiseInput {
  ConstFilmView film;
  const PackedGuides* guides;
  Canvas size;
  std::uint64_t samples;  ///< per pixel, at least 1
  float white;            ///< of the picture (film/error.h)
  float voxel;            ///< mm
  float fade = 1;         ///< denoiser_fade(), > 0
  /// For each kShareRows rows, where they differ.
  const std::uint64_t* by_stripe = nullptr;

  std::uint64_t samples_of(std::uint32_t row) const {
    return by_stripe == nullptr ? samples : by_stripe[row / kShareRows];
  }
};

/// The picture's radiance, three a pixel, smoothed (film/denoise.h). The same bits whatever the
/// number of threads. 90 bytes a pixel of memory while it runs.
std::vector<float> denoise(ThreadPool& pool, const DenoiseInput& input);

}  // namespace diaphane::render
