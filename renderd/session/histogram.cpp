#include "renderd/session/histogram.h"

#include <algorithm>
#include <vector>

namespace diaphane::render {
namespace {

constexpr std::size_t kMostBins = 256;
constexpr std::size_t kMostSampled = 4'000'000;

}  // namespace

diaphane::v1::Histogram histogram_of(const volume::Volume& volume) {
  const volume::Header& header = volume.header;
  const double values = static_cast<double>(header.maximum) - header.minimum + 1;
  const double width = std::max(1.0, values / kMostBins);
  std::vector<std::uint32_t> counts(std::min(kMostBins, static_cast<std::size_t>(values)));
  // Odd, because a stride that shares a factor with the row length would sample only some columns.
  const std::size_t stride = ((volume.voxels.size() + kMostSampled - 1) / kMostSampled) | 1;
  for (std::size_t i = 0; i < volume.voxels.size(); i += stride) {
    const std::int32_t value = volume.voxels[i];
    if (value < header.minimum || value > header.maximum) continue;
    const auto bin = static_cast<std::size_t>((value - header.minimum) / width);
    ++counts[std::min(bin, counts.size() - 1)];
  }
  diaphane::v1::Histogram histogram;
  histogram.set_minimum(header.minimum);
  histogram.set_width(width);
  histogram.mutable_counts()->Assign(counts.begin(), counts.end());
  return histogram;
}

}  // namespace diaphane::render
