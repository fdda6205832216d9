#pragma once

#include <cstdint>
#include <vector>

#include "renderd/engine/cpu/thread_pool.h"
#include "renderd/film/canvas.h"
#include "renderd/film/film.h"
#include "renderd/film/guides.h"
#include "renderd/film/part.h"

namespace diaphane::render {

/// The input of the denoiser.
struct DenoiseInput {
  ConstFilmView film;
  const PackedGuides* guides;
  Canvas size;
  std::uint64_t samples;  ///< per pixel, at least 1
  float white;            ///< white of the picture (film/error.h)
  float voxel;            ///< voxel size in mm
  float fade = 1;         ///< denoiser_fade(), > 0
  /// One number for each kShareRows rows, or null if all rows have `samples`.
  const std::uint64_t* by_stripe = nullptr;

  std::uint64_t samples_of(std::uint32_t row) const {
    return by_stripe == nullptr ? samples : by_stripe[row / kShareRows];
  }
};

/// Returns the denoised radiance, three numbers per pixel (film/denoise.h). The result does not
/// depend on the number of threads. Uses 112 bytes of memory per pixel, including the result.
std::vector<float> denoise(RendererThreads& threads, const DenoiseInput& input);

}  // namespace diaphane::render
