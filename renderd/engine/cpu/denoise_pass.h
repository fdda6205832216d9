#pragma once

#include <cstdint>

namespace diaphane::render {

/// The denoiser's working memory: planes of one float per pixel, rows from the top. This layout
/// lets loops along a row vectorise.
struct DenoisePlanes {
  static constexpr std::uint32_t kSmoothed = 5;  ///< red, green, blue, deviation, variance
  static constexpr std::uint32_t kSteering =
      10;  ///< whether the pixel takes part, opacity, depth, slope, albedo, normal

  std::uint32_t width, height;
  const float* from[kSmoothed];
  float* to[kSmoothed];
  const float* steering[kSteering];
};

/// Filters row `y` in one pass whose taps are `stride` pixels apart. `scratch` has kSmoothed + 1
/// rows. `voxel` is in mm.
using DenoiseRow = void (*)(const DenoisePlanes& planes, std::int32_t y, std::int32_t stride,
                            float voxel, float* scratch);

/// Returns the function that is compiled for the instruction set of this processor.
DenoiseRow denoise_row();

/// The two compilations of the same source.
void denoise_row_baseline(const DenoisePlanes& planes, std::int32_t y, std::int32_t stride,
                          float voxel, float* scratch);
void denoise_row_avx2(const DenoisePlanes& planes, std::int32_t y, std::int32_t stride, float voxel,
                      float* scratch);

}  // namespace diaphane::render
