#include "renderd/scene/framing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

namespace diaphane::render {
namespace {

/// Hounsfield units, between fat and air and well above the noise of air.
constexpr double kDenserThanAir = -300;
/// Share of the way from the darkest voxels to bright tissue at which tissue begins in MR and
/// others. Noise in the background stays below it.
constexpr double kTissueBegins = 0.3;
constexpr double kOutlying = 0.001;
constexpr std::uint64_t kNextToNone = 100;

double threshold(const volume::Header& header) {
  if (header.modality == volume::Modality::kCt) return kDenserThanAir;
  const double darkest = header.percentiles[0], bright = header.percentiles[5];
  return darkest + kTissueBegins * (bright - darkest);
}

/// Returns the indices between which all but kOutlying of the voxels at each end lie.
std::pair<double, double> range(const std::vector<std::uint64_t>& counts, std::uint64_t all) {
  const auto outlying = static_cast<std::uint64_t>(kOutlying * static_cast<double>(all));
  const auto skip = [&](auto from, auto to) {
    std::uint64_t passed = 0;
    return std::find_if(from, to, [&](std::uint64_t n) { return (passed += n) > outlying; }) - from;
  };
  const auto below = skip(counts.begin(), counts.end());
  const auto above = skip(counts.rbegin(), counts.rend());
  return {static_cast<double>(below),
          static_cast<double>(static_cast<std::ptrdiff_t>(counts.size()) - above)};
}

}  // namespace

Framing whole_box(const volume::Header& header) {
  Framing framing;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    framing.half_width[axis] = 0.5 * header.size[axis] * header.spacing[axis];
  }
  return framing;
}

Framing box_framing(const volume::Header& header, const std::array<double, 3>& low,
                    const std::array<double, 3>& high) {
  Framing framing;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    framing.half_width[axis] = 0.5 * (high[axis] - low[axis]) * header.spacing[axis];
    const double shift = 0.5 * (low[axis] + high[axis] - header.size[axis]) * header.spacing[axis];
    for (std::size_t i = 0; i < 3; ++i) framing.centre[i] += header.direction[3 * i + axis] * shift;
  }
  return framing;
}

Framing visible_part(const volume::Volume& volume) {
  const volume::Header& header = volume.header;
  std::array<std::vector<std::uint64_t>, 3> counts;
  for (std::size_t axis = 0; axis < 3; ++axis) counts[axis].resize(header.size[axis]);
  std::uint64_t all = 0;
  const double begins = threshold(header);
  auto voxel = volume.voxels.begin();
  for (std::uint32_t z = 0; z < header.size[2]; ++z) {
    for (std::uint32_t y = 0; y < header.size[1]; ++y) {
      for (std::uint32_t x = 0; x < header.size[0]; ++x) {
        if (*voxel++ <= begins) continue;
        ++counts[0][x];
        ++counts[1][y];
        ++counts[2][z];
        ++all;
      }
    }
  }
  if (all < kNextToNone) return whole_box(header);
  std::array<double, 3> low{}, high{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::tie(low[axis], high[axis]) = range(counts[axis], all);
  }
  return box_framing(header, low, high);
}

}  // namespace diaphane::render
