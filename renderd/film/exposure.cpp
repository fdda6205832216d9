#include "renderd/film/exposure.h"

#include <algorithm>
#include <cmath>

namespace diaphane::render {

Metering metering_of(const WhiteHistogram& histogram) {
  double sum = 0, count = 0;
  for (std::uint32_t bin = 0; bin < kWhiteBins; ++bin) {
    const auto here = static_cast<double>(histogram.counts[bin]);
    count += here;
    // The lowest bin holds zero and everything negative.
    if (bin == 0) continue;
    const double middle = std::ldexp(1.0 + (bin % 16 + 0.5) / 16, static_cast<int>(bin / 16) - 32);
    sum += here * middle;
  }
  return {white_from_histogram(histogram), count > 0 ? sum / count : 0};
}

double automatic_stops(double mean) {
  if (!(mean > 0) || !std::isfinite(mean)) return 0;
  const double wanted = std::clamp(mean, kDarkestMean, kBrightestMean);
  return std::clamp(std::log2(wanted / mean), -kUpToDarker, kUpToBrighter);
}

}  // namespace diaphane::render
