#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "renderd/engine/cuda_denoise.h"
#include "renderd/engine/cuda_kernels.h"
#include "renderd/engine/cuda_memory.h"
#include "renderd/engine/cuda_row_counts.h"
#include "renderd/film/canvas.h"
#include "renderd/film/error.h"
#include "renderd/film/part.h"

namespace diaphane::render::cuda {

/// A part's pixels on a device.
struct PackedPart final : PixelsOnDevice {
  int device = 0;
  DeviceBuffer<PackedPixel> pixels;
};

/// The accumulated picture of one canvas on the device: 40 bytes a pixel, 3 more once it was
/// displayed raw. Trace kernels add to it directly; after a launch that was the last before a stop
/// the upper rows have more samples than the lower ones, which every picture and the error allow
/// for.
class CudaFilm {
 public:
  static Result<CudaFilm> make(Canvas canvas);
  /// Whether reshape() can make it one of `canvas`.
  bool holds(Canvas canvas) const;
  /// To be cleared next; nothing may use it any more. No memory is allocated or freed, which would
  /// hold up every session of the device.
  void reshape(Canvas canvas);

  Canvas canvas() const { return canvas_; }
  std::uint64_t pixels() const { return std::uint64_t{canvas_.width} * canvas_.height; }
  /// Per pixel: of the rows that have the fewest.
  std::uint64_t samples() const;
  /// Since the share began, of those of its rows that have the fewest.
  std::uint64_t drawn() const { return rows_.least(); }
  bool empty() const { return rows_.least() == 0 && rows_.flat(); }
  std::uint32_t first_row() const { return first_row_; }
  std::uint64_t device_bytes() const;

  /// Whether guides are kept from the next clear() on: 6 bytes a pixel, which then stay, and hold
  /// the picture that is displayed while no guides are kept.
  Result<void> keep_guides(bool wanted);
  /// Also makes the share the whole.
  Result<void> clear(cudaStream_t stream);
  /// As FrameRenderer::set_share(), take_film() and merge_film(); the last two wait for the stream.
  Result<void> set_share(const Share& share);
  Result<bool> take(FilmPart& out, cudaStream_t stream);
  /// FrameRenderer::take_film_here(): the pixels are in memory of the device, of which two parts'
  /// is kept.
  Result<bool> take_here(FilmPart& out, cudaStream_t stream);
  Result<void> merge(const FilmPart& part, cudaStream_t stream);
  TraceTarget target() const {
    return {{sum_.data(), difference_.data(), state_.data()},
            dropped_.data(),
            guided_ ? guides_.data() : nullptr};
  }
  /// Null when none are kept.
  const PackedGuides* guides() const { return guided_ ? guides_.data() : nullptr; }
  /// What to trace next (rows from first_row() on), and that a launch which does its first `rows`
  /// rows is queued.
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
  std::uint32_t last_row() const { return first_row_ + rows_.rows(); }
  std::uint64_t samples_of(std::uint32_t row) const;
  /// What take() and take_here() have in common: the part without pixels; false: nothing to take.
  bool describe(FilmPart& out) const;
  Result<void> pack(const FilmPart& part, PackedPixel* to, cudaStream_t stream);
  void count_as_merged(std::uint32_t first_row, std::uint32_t last_row, std::uint64_t samples);
  /// The share's rows have one even number of samples.
  bool settled() const { return rows_.flat() && (rows_.least() - taken_) % 2 == 0; }

  Canvas canvas_;
  std::uint32_t first_row_ = 0;        ///< of the share
  RowCounts rows_;                     ///< of the share's rows, since it began
  std::uint64_t taken_ = 0;            ///< of those
  std::vector<std::uint64_t> merged_;  ///< from elsewhere, for each kShareRows rows; empty: none
  DeviceBuffer<double> sum_;
  DeviceBuffer<float> difference_;
  DeviceBuffer<std::uint32_t> state_;
  DeviceBuffer<std::uint64_t> dropped_;
  DeviceBuffer<PackedGuides> guides_;
  bool guided_ = false;
  // Made when first needed; no part of what the film is.
  mutable DeviceBuffer<std::uint64_t> by_stripe_;
  mutable DeviceBuffer<std::uint64_t> counts_;  ///< kWhiteCounts
  mutable DeviceBuffer<TileError> tiles_;
  mutable DeviceBuffer<std::uint8_t> display_;  ///< 3 a pixel
  DeviceBuffer<PackedPixel> packed_;
  std::array<std::shared_ptr<PackedPart>, 2>
      handed_;  ///< by take_here(); free with no other holder
};

}  // namespace diaphane::render::cuda
