#pragma once

#include <array>
#include <cstdint>

#include "renderd/engine/cuda_kernels.h"
#include "renderd/engine/cuda_memory.h"
#include "renderd/film/canvas.h"
#include "renderd/film/error.h"

namespace diaphane::render::cuda {

/// The accumulated picture of one canvas on the device: 40 bytes a pixel, 36 for the batch that is
/// being traced, 3 for the picture. A batch is folded whole or not at all, so every pixel always
/// has the same number of samples.
class CudaFilm {
 public:
  static Result<CudaFilm> make(Canvas canvas);

  Canvas canvas() const { return canvas_; }
  std::uint64_t pixels() const { return std::uint64_t{canvas_.width} * canvas_.height; }
  std::uint64_t samples() const { return samples_; }
  PixelBatch* batch() const { return batch_.data(); }

  Result<void> clear(cudaStream_t stream);
  Result<void> fold(std::uint32_t samples, cudaStream_t stream);

  // These wait for the stream.
  Result<std::uint64_t> dropped(cudaStream_t stream) const;
  /// As estimate_error of film/error.h, reduced on the device.
  Result<double> error(cudaStream_t stream) const;
  Result<void> display(float scale, std::uint8_t* rgb, cudaStream_t stream) const;
  Result<void> radiance(float* rgb, cudaStream_t stream) const;
  /// 1 where matter was met, else 0.
  Result<void> contents(std::uint8_t* met, cudaStream_t stream) const;

 private:
  ConstFilmView view() const { return {sum_.data(), difference_.data(), state_.data()}; }
  std::uint32_t tile_count() const;

  Canvas canvas_;
  std::uint64_t samples_ = 0;
  DeviceBuffer<double> sum_;
  DeviceBuffer<float> difference_;
  DeviceBuffer<std::uint32_t> state_;
  DeviceBuffer<PixelBatch> batch_;
  DeviceBuffer<std::uint64_t> dropped_;
  DeviceBuffer<std::uint64_t> counts_;  ///< kWhiteBins
  DeviceBuffer<TileError> tiles_;
  DeviceBuffer<std::uint8_t> picture_;  ///< as displayed, 3 a pixel
};

}  // namespace diaphane::render::cuda
