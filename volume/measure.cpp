#include <algorithm>

#include "volume/volume.h"

namespace diaphane::volume {

void measure(Volume& volume, const Filler& filler) {
  Header& header = volume.header;
  header.minimum = header.maximum = 0;
  header.percentiles.fill(0);
  if (volume.voxels.empty()) return;
  // An int16 has few enough values for an exact histogram.
  std::vector<std::uint64_t> histogram(65536);
  for (const std::int16_t v : volume.voxels) ++histogram[static_cast<std::uint16_t>(v ^ INT16_MIN)];
  std::uint64_t total = volume.voxels.size();
  std::uint64_t& air = histogram[static_cast<std::uint16_t>(filler.value ^ INT16_MIN)];
  if (filler.count < total) {  // with nothing but filler, the filler is measured
    const std::uint64_t left_out = std::min(filler.count, air);
    air -= left_out;
    total -= left_out;
  }
  const auto value_at = [](std::size_t bin) { return static_cast<std::int32_t>(bin) + INT16_MIN; };
  const auto filled = [](std::uint64_t n) { return n != 0; };
  header.minimum =
      value_at(std::find_if(histogram.begin(), histogram.end(), filled) - histogram.begin());
  header.maximum =
      value_at(histogram.rend() - std::find_if(histogram.rbegin(), histogram.rend(), filled) - 1);

  // Nearest-rank percentile: the smallest value with at least p % of the voxels at or below it.
  constexpr std::array<double, 8> kPercent{1, 10, 25, 50, 75, 90, 99, 99.9};
  std::uint64_t below = 0;
  std::size_t next = 0;
  for (std::size_t bin = 0; bin < histogram.size() && next < kPercent.size(); ++bin) {
    below += histogram[bin];
    while (next < kPercent.size() &&
           static_cast<double>(below) * 100 >= kPercent[next] * static_cast<double>(total)) {
      header.percentiles[next++] = value_at(bin);
    }
  }
}

}  // namespace diaphane::volume
