#pragma once

#include <cuda_runtime_api.h>

#include <cstdint>

#include "renderd/film/error.h"
#include "renderd/film/film.h"
#include "renderd/kernel/features.h"
#include "renderd/kernel/views.h"

// What the host asks of the device: each function queues one kernel on a stream and returns the
// status of the launch.

namespace diaphane::render::cuda {

/// Voxels in a 3D texture, fetched unfiltered and interpolated in fp32: the texture unit's own
/// filter has weights of 8 bits. The same numbers as LinearVolume's, in a layout where neighbours
/// along all axes are near.
struct TextureVolume {
  cudaTextureObject_t texture;  ///< int16, point sampling, element coordinates, clamped
  Int3 size;

#if defined(__CUDACC__)
  __device__ float at(Float3 index) const;
  __device__ ValueSpan corner_range(Int3 cell) const;
#endif
};

/// A part of one batch of samples: a stripe of rows.
struct Stripe {
  std::uint32_t first_row;    ///< a multiple of kStripeRows
  std::uint32_t rows;         ///< to be traced; the last ones may lie below the picture
  std::uint64_t film_sample;  ///< since the film was cleared: its parity chooses the half
  std::uint32_t samples;      ///< per pixel
  std::uint32_t lane_shift;   ///< 2^lane_shift threads share a pixel's samples
};
inline constexpr std::uint32_t kStripeRows = 8;
inline constexpr std::uint32_t kMostLaneShift = 5;  ///< a warp

/// Traces the stripe with the variant for `features` and writes its pixels of `batch` (one entry a
/// pixel).
cudaError_t trace(Features features, const SceneView<TextureVolume>& scene, const Stripe& stripe,
                  PixelBatch* batch, cudaStream_t stream);

/// Whether the device has code for the kernels.
cudaError_t probe();

/// Adds a whole batch to the film, and what it dropped to `dropped`.
cudaError_t fold_batch(const FilmView& film, const PixelBatch* batch, std::uint64_t pixels,
                       std::uint64_t* dropped, cudaStream_t stream);

/// Adds the colours of the pixels that met matter to the kWhiteBins `counts`, which the
/// caller has cleared.
cudaError_t white_histogram(const ConstFilmView& film, std::uint64_t pixels, std::uint64_t samples,
                            std::uint64_t* counts, cudaStream_t stream);

/// One entry a tile of kTileSize, rows from the top.
cudaError_t tile_errors(const ConstFilmView& film, std::uint32_t width, std::uint32_t height,
                        std::uint64_t samples, float inverse_white, TileError* tiles,
                        cudaStream_t stream);

/// 3 numbers a pixel.
cudaError_t display_film(const ConstFilmView& film, std::uint64_t pixels, std::uint64_t samples,
                         float scale, std::uint8_t* rgb, cudaStream_t stream);
cudaError_t mean_of_film(const ConstFilmView& film, std::uint64_t pixels, std::uint64_t samples,
                         float* rgb, cudaStream_t stream);

}  // namespace diaphane::render::cuda
