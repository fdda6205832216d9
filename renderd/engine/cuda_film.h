#pragma once

#include <cstdint>

#include "renderd/engine/cuda_denoise.h"
#include "renderd/engine/cuda_kernels.h"
#include "renderd/engine/cuda_memory.h"
#include "renderd/engine/cuda_row_counts.h"
#include "renderd/film/canvas.h"
#include "renderd/film/error.h"

namespace diaphane::render::cuda {

/// The accumulated picture of one canvas on the device: 40 bytes a pixel, 3 more once it was
/// displayed raw. Trace kernels add to it directly; after a launch that was the last before a stop
/// the upper rows have more samples than the lower ones, which every picture and the error allow
/// for.
class CudaFilm {
 public:
  static Result<CudaFilm> make(Canvas canvas);

  Canvas canvas() const { return canvas_; }
  std::uint64_t pixels() const { return std::uint64_t{canvas_.width} * canvas_.height; }
  /// Per pixel: of the rows that have the fewest.
  std::uint64_t samples() const { return rows_.least(); }
  bool empty() const { return rows_.least() == 0 && rows_.flat(); }
  std::uint64_t device_bytes() const;

  /// Whether guides are kept from the next clear() on: 6 bytes a pixel.
  Result<void> keep_guides(bool wanted);
  Result<void> clear(cudaStream_t stream);
  TraceTarget target() const {
    return {{sum_.data(), difference_.data(), state_.data()}, dropped_.data(), guides_.data()};
  }
  /// Null when none are kept.
  const PackedGuides* guides() const { return guides_.data(); }
  /// What to trace next, and that a launch which does its first `rows` rows is queued.
  RowCounts::Piece next(std::uint64_t target, std::uint32_t most) const {
    return rows_.next(target, most);
  }
  void done(const RowCounts::Piece& piece, std::uint32_t rows) { rows_.done(piece, rows); }

  // These wait for the stream. What they need beside the film is allocated by the first call, so
  // kOutOfMemory is possible and leaves the film as it is.
  Result<std::uint64_t> dropped(cudaStream_t stream) const;
  /// As estimate_error of film/error.h, reduced on the device.
  Result<double> error(cudaStream_t stream) const;
  Result<void> display(float scale, std::uint8_t* rgb, cudaStream_t stream) const;
  Result<void> radiance(float* rgb, cudaStream_t stream) const;
  /// As display() and radiance(), smoothed; guides are kept and there are samples. `fade`:
  /// denoiser_fade(), > 0. `voxel`: mm.
  Result<void> display_denoised(CudaDenoiser& denoiser, float voxel, float fade, float scale,
                                std::uint8_t* rgb, cudaStream_t stream) const;
  Result<void> radiance_denoised(CudaDenoiser& denoiser, float voxel, float fade, float* rgb,
                                 cudaStream_t stream) const;
  /// 1 where matter was met, else 0.
  Result<void> contents(std::uint8_t* met, cudaStream_t stream) const;

 private:
  /// The film as it stands; uploads the counts of the rows where they differ.
  Result<FilmPicture> picture(cudaStream_t stream) const;
  /// Of film/error.h.
  Result<float> white(const FilmPicture& film, cudaStream_t stream) const;
  Result<DenoiseWork> denoise_work(float voxel, float fade, cudaStream_t stream) const;
  std::uint32_t tile_count() const;

  Canvas canvas_;
  RowCounts rows_;
  DeviceBuffer<double> sum_;
  DeviceBuffer<float> difference_;
  DeviceBuffer<std::uint32_t> state_;
  DeviceBuffer<std::uint64_t> dropped_;
  DeviceBuffer<PackedGuides> guides_;
  // Made when first needed; no part of what the film is.
  mutable DeviceBuffer<std::uint64_t> by_stripe_;
  mutable DeviceBuffer<std::uint64_t> counts_;  ///< kWhiteCounts
  mutable DeviceBuffer<TileError> tiles_;
  mutable DeviceBuffer<std::uint8_t> display_;  ///< 3 a pixel
};

}  // namespace diaphane::render::cuda
