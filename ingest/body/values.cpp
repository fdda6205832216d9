#include "ingest/body/values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace diaphane::ingest {
namespace {

constexpr int kSkinHu = -300;
constexpr int kFoamHu = -930;  // scatter raises air to about -960
constexpr int kAirHu = -700;   // a CT in Hounsfield units has air below this
constexpr std::size_t kMostSamples = 1 << 20;

constexpr int kLowest = std::numeric_limits<std::int16_t>::min();
using Histogram = std::vector<std::uint32_t>;  // index: value - kLowest

Histogram histogram_of(std::span<const std::int16_t> voxels) {
  Histogram histogram(1 << 16, 0);
  // An odd step does not stay on the same columns of the volume.
  const std::size_t step = (voxels.size() / kMostSamples) | 1;
  for (std::size_t i = 0; i < voxels.size(); i += step) {
    ++histogram[static_cast<std::size_t>(voxels[i] - kLowest)];
  }
  return histogram;
}

/// Returns Otsu's threshold between two classes.
double otsu(const Histogram& histogram) {
  double total = 0, sum = 0;
  for (std::size_t i = 0; i < histogram.size(); ++i) {
    total += histogram[i];
    sum += static_cast<double>(i) * histogram[i];
  }
  double below = 0, sum_below = 0, most = -1;
  std::size_t best = 0;
  for (std::size_t i = 0; i < histogram.size(); ++i) {
    below += histogram[i];
    sum_below += static_cast<double>(i) * histogram[i];
    if (histogram[i] == 0 || below == total) continue;
    const double difference = sum_below / below - (sum - sum_below) / (total - below);
    const double between = below * (total - below) * difference * difference;
    if (between > most) {
      most = between;
      best = i;
    }
  }
  return static_cast<double>(best) + kLowest;
}

struct Background {
  double median = 0, upper = 0;  ///< `upper` bounds 97.5% of a Rayleigh distribution
};

/// Estimates the values of air from those below `limit`. The lower half of these is air even where
/// dark tissue is as frequent as noise.
Background background_below(const Histogram& histogram, double limit) {
  const auto end = static_cast<std::size_t>(std::max(0.0, limit - kLowest)) + 1;
  double total = 0;
  for (std::size_t i = 0; i < std::min(end, histogram.size()); ++i) total += histogram[i];
  const auto quantile = [&](double share) {
    double sum = 0;
    for (std::size_t i = 0; i < std::min(end, histogram.size()); ++i) {
      sum += histogram[i];
      if (sum >= share * total) return static_cast<double>(i) + kLowest;
    }
    return limit;
  };
  const double low = quantile(0.02), quarter = quantile(0.25), median = quantile(0.5);
  // For a Rayleigh distribution, the quantiles of 2% and 25% are at 0.20 and 0.76 sigma, so the
  // bound is at 2.72 sigma, which 97.5% of the values are below.
  return {median, quarter + 3.5 * (quarter - low)};
}

}  // namespace

bool is_hounsfield(const volume::Header& header) {
  const bool may_be_ct =
      header.modality == volume::Modality::kCt || header.modality == volume::Modality::kOther;
  return may_be_ct && header.minimum <= kAirHu && header.maximum > kSkinHu;
}

ValueScale value_scale(const volume::Volume& volume) {
  const volume::Header& header = volume.header;
  if (is_hounsfield(header)) return {true, true, false, kSkinHu, kFoamHu};
  const Histogram histogram = histogram_of(volume.voxels);
  const double middle = otsu(histogram);
  const Background air = background_below(histogram, middle);
  // CT has foam between air and skin, and its values are proportional to density. MR has dark skin.
  const double share = header.modality == volume::Modality::kCt ? 0.7 : 0.15;
  const double level = std::max(air.upper, air.median + share * (middle - air.median));
  return {false, header.modality == volume::Modality::kCt, air.upper > air.median,
          static_cast<int>(std::floor(std::min(level, middle))) + 1, 0};
}

}  // namespace diaphane::ingest
