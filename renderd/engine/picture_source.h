#pragma once

#include <cstdint>
#include <vector>

#include "common/result.h"
#include "renderd/film/canvas.h"

namespace diaphane::render {

/// A picture for display, with a curve similar to sRGB: 8 bits per component, interleaved RGB, rows
/// from the top, no padding.
struct PictureRgb8 {
  Canvas size;
  std::vector<std::uint8_t> pixels;
};

/// A picture of linear radiance: interleaved RGB, rows from the top, no padding.
struct PictureRgbF {
  Canvas size;
  std::vector<float> pixels;
};

/// Reads pictures from accumulated samples. Reading changes neither the samples nor their error.
/// Every function returns kOutOfMemory or kDeviceLost if the device fails.
class PictureSource {
 public:
  virtual ~PictureSource() = default;

  /// Writes the tone-mapped picture.
  virtual Result<void> display(PictureRgb8& out) = 0;
  /// Writes the picture before tone mapping.
  virtual Result<void> radiance(PictureRgbF& out) = 0;
  /// Writes 1 for each pixel whose camera ray has hit contents of the volume, otherwise 0, rows
  /// from the top. The error estimate counts the pixels that are 1.
  virtual Result<void> contents(std::vector<std::uint8_t>& out) = 0;

  /// Decides whether the first samples of the next scene also record the guides that the two
  /// functions below need. This costs some speed and 6 bytes per pixel, on the CPU 32 more while
  /// guides are recorded. Without guides, these functions return the raw picture.
  virtual void prepare_denoising(bool) {}
  /// Works like display(), but denoises as far as that reduces the error (film/denoise.h), so only
  /// before the picture has converged. Returns false if the picture is raw.
  virtual Result<bool> display_denoised(PictureRgb8& out) {
    return display(out).map([] { return false; });
  }
  /// Works like radiance(), denoised in the same way as display_denoised().
  virtual Result<bool> radiance_denoised(PictureRgbF& out) {
    return radiance(out).map([] { return false; });
  }
};

}  // namespace diaphane::render
