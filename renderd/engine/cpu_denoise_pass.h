#pragma once

#include <cstdint>

namespace diaphane::render {

/// The denoiser's working memory as planes of one float a pixel, rows from the top: loops along a
/// row vectorise.
struct DenoisePlanes {
  static constexpr std::uint32_t kSmoothed = 5;  ///< red, green, blue, deviation, variance
  static constexpr std::uint32_t kSteering =
      10;  ///< takes part, opacity, depth, slope, albedo, normal

  std::uint32_t width, height;
  const float* from[kSmoothed];
  float* to[kSmoothed];
  const float* steering[kSteering];
};

/// Row `y` of one pass of the filter whose taps are `stride` pixels apart. `scratch`: kSmoothed + 1
/// rows. `voxel`: mm.
using DenoiseRow = void (*)(const DenoisePlanes& planes, std::int32_t y, std::int32_t stride,
                            float voxel, float* scratch);

/// Compiled for this processor's instructions.
DenoiseRow denoise_row();

/// The same source compiled twice.
void denoise_row_baseline(const DenoisePlanes& planes, std::int32_t y, std::int32_t stride,
                          float voxel, float* scratch);
void denoise_row_avx2(const DenoisePlanes& planes, std::int32_t y, std::int32_t stride, float voxel,
                      float* scratch);

}  // namespace diaphane::render
