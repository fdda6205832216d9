#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "renderd/engine/cuda/denoise.h"
#include "renderd/engine/cuda/kernels.h"
#include "renderd/engine/cuda/memory.h"
#include "renderd/engine/cuda/row_counts.h"
#include "renderd/film/canvas.h"
#include "renderd/film/error.h"
#include "renderd/film/exposure.h"
#include "renderd/film/part.h"

namespace diaphane::render::cuda {

/// The pixels of a part in device memory.
struct PackedPart final : PixelsOnDevice {
  int device = 0;
  DeviceBuffer<PackedPixel> pixels;
  DeviceBuffer<PackedGuides> guides;
  bool guided = false;  ///< whether `guides` belong to the part
};

/// The accumulated picture of one canvas on the device: 40 bytes per pixel, 6 more with guides, and
/// 3 more after it was displayed raw. Trace kernels add to it directly. After a stopped batch, the
/// upper rows have more samples than the lower rows. All pictures and the error allow for this.
class CudaFilm {
 public:
  static Result<CudaFilm> make(Canvas canvas);
  /// Returns whether reshape() can change the film to `canvas`.
  bool holds(Canvas canvas) const;
  /// Changes the canvas. No work may still use the film, and clear() must follow. Does not
  /// allocate or free memory, which would delay every session of the device.
  void reshape(Canvas canvas);
  /// Sets the curve of display() and of the error. The default is linear.
  void set_curve(ToneCurve curve) { curve_ = curve; }

  Canvas canvas() const { return canvas_; }
  std::uint64_t pixels() const { return std::uint64_t{canvas_.width} * canvas_.height; }
  /// Returns the number of samples per pixel in the rows with the fewest.
  std::uint64_t samples() const;
  /// Returns the same number for the rows of the share, counted since the share began.
  std::uint64_t drawn() const { return rows_.least(); }
  bool empty() const { return rows_.least() == 0 && rows_.flat(); }
  std::uint32_t first_row() const { return first_row_; }
  std::uint64_t device_bytes() const;

  /// Sets whether guides are kept from the next clear() on. Their memory, 6 bytes per pixel, is not
  /// freed, and holds the displayed picture while no guides are kept.
  Result<void> keep_guides(bool enabled);
  /// Removes all samples and resets the share to the whole picture.
  Result<void> clear(cudaStream_t stream);
  /// These implement FilmExchange::set_share(), take_film() and merge_film(). The last two wait for
  /// the stream.
  Result<void> set_share(const Share& share);
  Result<bool> take(FilmPart& out, cudaStream_t stream);
  /// Implements FilmExchange::take_film_here(). The pixels stay in device memory, and the memory of
  /// two parts is kept for reuse.
  Result<bool> take_here(FilmPart& out, cudaStream_t stream);
  Result<void> merge(const FilmPart& part, cudaStream_t stream);
  TraceTarget target() const {
    return {{sum_.data(), difference_.data(), state_.data()},
            dropped_.data(),
            guided_ ? guides_.data() : nullptr};
  }
  /// Returns the guides of all pixels, or null if no guides are kept.
  const PackedGuides* guides() const { return guided_ ? guides_.data() : nullptr; }
  /// next() returns the rows and samples to trace next, in rows counted from first_row(). done()
  /// records that a launch with the first `rows` rows of `piece` is queued.
  RowCounts::Piece next(std::uint64_t target, std::uint32_t most) const {
    return rows_.next(target, most);
  }
  void done(const RowCounts::Piece& piece, std::uint32_t rows) {
    rows_.done(piece, rows);
    metering_.reset();
  }

  // The following functions wait for the stream. The first call allocates the additional memory
  // that they need, so they may fail with kOutOfMemory, which leaves the film unchanged.
  Result<std::uint64_t> dropped(cudaStream_t stream) const;
  struct Measured {
    double error;  ///< total_error() of film/error.h
    double mean;   ///< Metering::mean of film/exposure.h
  };
  /// Measures the picture on the device. With one sample, it only measures the mean, and only if
  /// `with_mean`.
  Result<Measured> measure(bool with_mean, cudaStream_t stream) const;
  Result<void> display(float scale, std::uint8_t* rgb, cudaStream_t stream) const;
  Result<void> radiance(float* rgb, cudaStream_t stream) const;
  /// These work like display() and radiance(), but denoise. Guides must be kept and there must be
  /// samples. `fade` is denoiser_fade(), > 0. `voxel` is in mm.
  Result<void> display_denoised(CudaDenoiser& denoiser, float voxel, float fade, float scale,
                                std::uint8_t* rgb, cudaStream_t stream) const;
  Result<void> radiance_denoised(CudaDenoiser& denoiser, float voxel, float fade, float* rgb,
                                 cudaStream_t stream) const;
  /// Writes 1 for each pixel whose ray hit matter, otherwise 0.
  Result<void> contents(std::uint8_t* met, cudaStream_t stream) const;

 private:
  /// Returns the film as kernels see it, and uploads the counts of the rows if they differ.
  Result<FilmPicture> picture(cudaStream_t stream) const;
  /// Measures the film, and keeps the result until the film changes.
  Result<Metering> metering(const FilmPicture& film, cudaStream_t stream) const;
  Result<DenoiseWork> denoise_work(float voxel, float fade, cudaStream_t stream) const;
  std::uint32_t tile_count() const;
  std::uint32_t last_row() const { return first_row_ + rows_.rows(); }
  std::uint64_t samples_of(std::uint32_t row) const;
  /// Fills in the part except for its pixels, for take() and take_here(). Returns false if there is
  /// nothing to take.
  bool describe(FilmPart& out) const;
  /// Returns whether the part from describe() brings guides (FilmPart::guides).
  bool brings_guides(const FilmPart& part) const {
    return guided_ && taken_ < kGuidedSamples && part.rows < canvas_.height;
  }
  Result<void> merge_guides(const FilmPart& part, const PackedPart* packed, int here,
                            cudaStream_t stream);
  Result<void> pack(const FilmPart& part, PackedPixel* to, cudaStream_t stream);
  void count_as_merged(std::uint32_t first_row, std::uint32_t last_row, std::uint64_t samples);
  /// Returns whether all rows of the share have the same, even number of samples.
  bool settled() const { return rows_.flat() && (rows_.least() - taken_) % 2 == 0; }

  Canvas canvas_;
  std::uint32_t first_row_ = 0;        ///< first row of the share
  RowCounts rows_;                     ///< samples of the share's rows since the share began
  std::uint64_t taken_ = 0;            ///< number of these samples that were taken
  std::vector<std::uint64_t> merged_;  ///< samples of other devices per kShareRows rows, or empty
  DeviceBuffer<double> sum_;
  DeviceBuffer<float> difference_;
  DeviceBuffer<std::uint32_t> state_;
  DeviceBuffer<std::uint64_t> dropped_;
  DeviceBuffer<PackedGuides> guides_;
  bool guided_ = false;
  ToneCurve curve_ = ToneCurve::kLinear;
  mutable std::optional<Metering> metering_;
  // Buffers that are allocated when first needed and are not part of the film's state.
  mutable DeviceBuffer<std::uint64_t> by_stripe_;
  mutable DeviceBuffer<std::uint64_t> counts_;  ///< kWhiteCounts
  mutable DeviceBuffer<TileError> tiles_;
  mutable DeviceBuffer<std::uint8_t> display_;  ///< 3 per pixel
  DeviceBuffer<PackedPixel> packed_;
  /// The parts of take_here(). A part is reused when it has no other holder.
  std::array<std::shared_ptr<PackedPart>, 2> handed_;
};

}  // namespace diaphane::render::cuda
