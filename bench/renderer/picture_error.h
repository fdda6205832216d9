#pragma once

#include <cstdint>
#include <vector>

#include "renderd/engine/frame_renderer.h"

// The true error of a picture as film/error.h defines it, against a converged picture. Computed in
// plain double precision by code that shares nothing with the film's estimate.

namespace diaphane::render::bench {

/// A converged picture with its own estimator and seed.
struct Reference {
  Canvas canvas;
  std::vector<double> mean;            ///< radiance, 3 values per pixel
  std::vector<std::uint8_t> contents;  ///< 1 for pixels whose rays met contents, which count
  double samples = 0;                  ///< per pixel
  double error = 0;                    ///< its own estimated error
  double seconds = 0;                  ///< time that it took
  double white = 1;                    ///< 99th percentile over the pixels that count
  bool filmic = false;                 ///< the scene's display curve, FILMIC or LINEAR
};

/// Returns the 99th percentile of `mean` over the colours of the pixels that count, or 1 if there
/// are none or it is not positive.
double white_of(const std::vector<double>& mean, const std::vector<std::uint8_t>& contents);

/// Returns x^(1/2.2) for x clipped to [0, 1], which the filmic curve maps to [0, 1] first.
double exact_tone(double x, bool filmic = false);

struct PictureError {
  double rmse = 0;               ///< over the pixels that count, including the reference's noise
  std::uint64_t pixels = 0;      ///< number of pixels that count
  std::uint64_t non_finite = 0;  ///< non-finite values in the whole picture, excluded from the rmse
};
PictureError error_against(const Reference& reference, const PictureRgbF& picture);

/// Removes the reference's own error, which is independent, from `measured`: the root of the
/// difference of the squares, or 0 if that is negative.
double without_noise_of(const Reference& reference, double measured);

}  // namespace diaphane::render::bench
