#pragma once

#include <cmath>

#include "renderd/film/error.h"

// Automatic exposure, like that of a camera which meters the subject alone. It measures the mean
// radiance of the pixels that hit contents, because noise changes a median or a percentile but not
// a mean: the first sample gives the same exposure as the last. A well exposed picture keeps its
// exposure, so that it looks as the author of its settings intended. A brighter or darker picture
// is brought to the nearer end of the well exposed range. The correction is continuous in the mean,
// so the picture does not flicker while the subject turns.

namespace diaphane::render {

/// Measurements from the histogram of a picture.
struct Metering {
  float white = 1;  ///< white_from_histogram()
  /// The mean radiance over the three colours of the pixels that hit contents, or 0 if there are
  /// none. The bins cause a relative error of at most 1/32 (0.05 stops).
  double mean = 0;
};
Metering metering_of(const WhiteHistogram& histogram);

/// The range of mean radiance of well exposed pictures: 0.23 plus or minus three quarters of a
/// stop. A radiance of 0.23 is 62% of white by the filmic curve and 51% by the linear curve.
inline constexpr double kDarkestMean = 0.14, kBrightestMean = 0.39;
/// The largest corrections, in stops. They are limited, so that a subject in the dark stays dark.
inline constexpr double kUpToBrighter = 4, kUpToDarker = 10;

/// Returns the stops to add to the exposure for a subject of this mean radiance. The result does
/// not depend on the exposure, so a user can still make the picture brighter or darker. Returns 0
/// for a mean that is not positive and finite.
double automatic_stops(double mean);

/// Returns the factor of the radiance for an exposure in stops: 2^exposure.
inline float display_scale(double exposure) { return static_cast<float>(std::exp2(exposure)); }

}  // namespace diaphane::render
