#pragma once

#include <cstdint>
#include <mutex>
#include <optional>

#include "renderd/engine/cuda/kernels.h"
#include "renderd/engine/cuda/memory.h"
#include "renderd/film/denoise.h"

namespace diaphane::render::cuda {

/// Working memory of the denoiser: 80 bytes per pixel.
struct DenoiseBuffers {
  Float4 *raw, *from, *to;  ///< red, green, blue in units of white, and the luminance's deviation
  float *variance, *from_variance, *to_variance;
  PackedSteering* steering;
  float* slope;  ///< mm per pixel
  Gain* gains;   ///< one per tile of kGainTile
};

struct DenoiseWork {
  FilmPicture picture;
  const PackedGuides* guides;
  float white;
  float voxel;  ///< mm
  float fade;   ///< denoiser_fade(), > 0
  ToneCurve curve;
  DenoiseBuffers buffers;
};

/// Queues the whole filter and then the blend. Of the buffers, the blend reads only `from`,
/// `steering` and `gains`. It writes either `rgb` (radiance times `scale` through the display
/// curve) or `radiance`; the other pointer is null. Both have 3 numbers per pixel.
cudaError_t denoise(DenoiseWork work, float scale, std::uint8_t* rgb, float* radiance,
                    cudaStream_t stream);

/// Runs denoise() in working memory that also holds the finished picture. All sessions of a device
/// take turns to use it. Film and guides belong to the session.
class CudaDenoiser {
 public:
  /// Works like denoise(), but writes to host memory and waits for the stream. Fills in
  /// `work.buffers`.
  Result<void> run(DenoiseWork work, float scale, std::uint8_t* rgb, float* radiance,
                   cudaStream_t stream);
  /// Returns the duration of the kernels of the last run(), measured between two events on the
  /// stream, or 0 before the first run.
  double last_milliseconds() const;

 private:
  Result<void> grow(std::uint64_t pixels, std::uint64_t tiles);

  mutable std::mutex mutex_;
  DeviceBuffer<Float4> raw_, from_, to_;
  DeviceBuffer<float> variance_, from_variance_, to_variance_, slope_;
  DeviceBuffer<PackedSteering> steering_;
  DeviceBuffer<Gain> gains_;
  std::optional<Event> begin_, end_;
  float milliseconds_ = 0;
};

}  // namespace diaphane::render::cuda
