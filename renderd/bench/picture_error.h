#pragma once

#include <cstdint>
#include <vector>

#include "renderd/engine/frame_renderer.h"

// The true error of a picture: film/error.h's definition against a converged picture, by plain
// double precision code that shares nothing with the film's estimate.

namespace diaphane::render::bench {

/// A converged picture, by an estimator and a seed of its own.
struct Reference {
  Canvas canvas;
  std::vector<double> mean;            ///< radiance, 3 a pixel
  std::vector<std::uint8_t> contents;  ///< pixels whose rays met contents: those that count
  double samples = 0;                  ///< per pixel
  double error = 0;                    ///< its own estimated error
  double seconds = 0;                  ///< that it took
  double white = 1;                    ///< 99th percentile over the pixels that count
};

/// The 99th percentile of `mean` over the pixels that count and their colours; 1 when there are
/// none or it is not positive.
double white_of(const std::vector<double>& mean, const std::vector<std::uint8_t>& contents);

/// x^(1/2.2) of x clipped to [0, 1].
double exact_tone(double x);

struct PictureError {
  double rmse = 0;               ///< over the pixels that count; the reference's noise is in it
  std::uint64_t pixels = 0;      ///< that count
  std::uint64_t non_finite = 0;  ///< numbers of the whole picture, left out of the rmse
};
PictureError error_against(const Reference& reference, const PictureRgbF& picture);

/// `measured` without the reference's own error, which is independent of it: the root of the
/// difference of the squares, 0 where that is negative.
double without_noise_of(const Reference& reference, double measured);

}  // namespace diaphane::render::bench
