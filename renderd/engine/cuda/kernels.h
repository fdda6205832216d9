#pragma once

#include <cuda_runtime_api.h>

#include <cstdint>

#include "renderd/engine/cuda/trace_types.h"
#include "renderd/film/error.h"
#include "renderd/film/film.h"
#include "renderd/film/part.h"

// Kernels that read the film and exchange its samples. Each function queues one kernel on a stream
// and returns the status of the launch.

namespace diaphane::render::cuda {

/// Samples per row of a film: the same number for all rows, or one number per stripe of kStripeRows
/// rows after a stopped batch or in a shared picture.
struct RowSamples {
  std::uint64_t everywhere;
  const std::uint64_t* by_stripe;  ///< on the device; null if all rows have the same number

  HOST_DEVICE std::uint64_t of(std::uint32_t row) const {
    return by_stripe == nullptr ? everywhere : by_stripe[row / kStripeRows];
  }
};

/// The film as its kernels see it.
struct FilmPicture {
  ConstFilmView film;
  std::uint32_t width, height;
  RowSamples samples;
};

/// Adds the colours of the pixels that hit matter to the kWhiteCounts `counts` of a WhiteHistogram,
/// which the caller has cleared.
cudaError_t white_histogram(const FilmPicture& picture, std::uint64_t* counts, cudaStream_t stream);

/// Computes the error of each tile of kTileSize, rows from the top.
cudaError_t tile_errors(const FilmPicture& picture, float inverse_white, ToneCurve curve,
                        TileError* tiles, cudaStream_t stream);

/// Writes the picture for display, 3 numbers per pixel.
cudaError_t display_film(const FilmPicture& picture, float scale, ToneCurve curve,
                         std::uint8_t* rgb, cudaStream_t stream);
/// Writes the mean radiance of the pixels [first, first + count), 3 numbers per pixel.
cudaError_t mean_of_film(const FilmPicture& picture, std::uint64_t first, std::uint64_t count,
                         float* rgb, cudaStream_t stream);

/// Packs the pixels [first, first + count), which have `samples` samples each, and clears them.
cudaError_t pack_film(const FilmView& film, std::uint64_t first, std::uint64_t count,
                      std::uint64_t samples, PackedPixel* out, cudaStream_t stream);
/// Adds `count` packed pixels of `samples` samples each to the pixels from `first` on.
cudaError_t merge_packed(const PackedPixel* packed, std::uint64_t first, std::uint64_t count,
                         std::uint64_t samples, const FilmView& film, cudaStream_t stream);

}  // namespace diaphane::render::cuda
