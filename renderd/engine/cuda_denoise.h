#pragma once

#include <cstdint>
#include <mutex>
#include <optional>

#include "renderd/engine/cuda_kernels.h"
#include "renderd/engine/cuda_memory.h"
#include "renderd/film/denoise.h"

namespace diaphane::render::cuda {

/// Working memory of the denoiser: 80 bytes a pixel.
struct DenoiseBuffers {
  Float4 *raw, *from, *to;  ///< red, green, blue in units of white, and the luminance's deviation
  float *variance, *from_variance, *to_variance;
  PackedSteering* steering;
  float* slope;  ///< mm a pixel
  Gain* gains;   ///< one a tile of kGainTile
};

struct DenoiseWork {
  FilmPicture picture;
  const PackedGuides* guides;
  float white;
  float voxel;  ///< mm
  float fade;   ///< denoiser_fade(), > 0
  DenoiseBuffers buffers;
};

/// Queues the whole filter and then the blend, which reads no more of the buffers than `raw`,
/// `from`, `steering` and `gains`: radiance times `scale` through the display's curve
/// into `rgb`, or radiance into `radiance`; the other is null. 3 numbers a pixel.
cudaError_t denoise(DenoiseWork work, float scale, std::uint8_t* rgb, float* radiance,
                    cudaStream_t stream);

/// Carries denoise() out in memory of its own, which sessions share by taking turns, the finished
/// picture included; film and guides are the session's own.
class CudaDenoiser {
 public:
  /// As denoise(), into memory of the host; waits for the stream. `work.buffers` is filled in here.
  Result<void> run(DenoiseWork work, float scale, std::uint8_t* rgb, float* radiance,
                   cudaStream_t stream);
  /// Of the kernels of the last run(), between two events on the stream; 0: none yet.
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
