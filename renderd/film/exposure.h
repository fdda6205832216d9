#pragma once

#include <cmath>

#include "renderd/film/error.h"

// Automatic exposure, like that of a camera which meters the subject alone. It measures the mean
// radiance of the pixels that hit contents, because noise changes a median or a percentile but not
// a mean: the first sample gives the same exposure as the last. A picture that is well exposed as
// it is keeps its exposure, so that looks stay as their authors made them; a brighter or darker one
// is brought to the nearer end of that range. The correction is continuous in the mean, so it does
// not flicker while the subject turns.

namespace diaphane::render {

/// What the histogram of a picture tells.
struct Metering {
  float white = 1;  ///< white_from_histogram()
  /// The mean radiance over the three colours of the pixels that hit contents, or 0 if there are
  /// none. The bins make it inexact by at most 1/32 (0.05 stops).
  double mean = 0;
};
Metering metering_of(const WhiteHistogram& histogram);

/// The mean radiance of well exposed pictures: three quarters of a stop around 0.23, which is 62%
/// of white by the filmic curve and 51% by the linear one.
inline constexpr double kDarkestMean = 0.14, kBrightestMean = 0.39;
/// The largest corrections, in stops. A subject in the dark stays dark.
inline constexpr double kUpToBrighter = 4, kUpToDarker = 10;

/// Returns the stops to add to the exposure for a subject of this mean radiance. They do not depend
/// on the exposure, so changing that still makes the picture brighter or darker. Returns 0 for a
/// mean of 0, and for one that is not finite.
double automatic_stops(double mean);

/// Returns the factor of the radiance for an exposure in stops: 2^exposure.
inline float display_scale(double exposure) { return static_cast<float>(std::exp2(exposure)); }

}  // namespace diaphane::render
