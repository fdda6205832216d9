#include "renderd/scene/brain.h"

#include <algorithm>
#include <array>
#include <vector>

#include "volume/labels.h"

namespace diaphane::render {

std::optional<BrainFacts> brain_of(const volume::Volume& volume) {
  if (!volume::has_brain(volume)) return std::nullopt;
  // A label set that is full has no room for the brain (volume::list_found_labels()).
  const auto& table = volume.label_set.table;
  const bool listed = std::any_of(table.begin(), table.end(), [](const auto& entry) {
    return entry.number == volume::kBrainNumber;
  });
  if (!listed && table.size() >= volume::kMostLabels) return std::nullopt;
  const volume::Header& header = volume.header;
  const auto labels = volume::decode(volume.labels, header.size);
  if (!labels) return std::nullopt;
  std::vector<std::int16_t> values;
  std::array<double, 3> low{}, high{};
  std::copy(header.size.begin(), header.size.end(), low.begin());
  std::size_t voxel = 0;
  for (std::uint32_t z = 0; z < header.size[2]; ++z) {
    for (std::uint32_t y = 0; y < header.size[1]; ++y) {
      for (std::uint32_t x = 0; x < header.size[0]; ++x, ++voxel) {
        if (labels->voxels[voxel] != static_cast<std::uint8_t>(volume::Label::kBrain)) continue;
        values.push_back(volume.voxels[voxel]);
        const std::array<double, 3> at{double(x), double(y), double(z)};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          low[axis] = std::min(low[axis], at[axis]);
          high[axis] = std::max(high[axis], at[axis] + 1);
        }
      }
    }
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return BrainFacts{static_cast<double>(*middle), box_framing(header, low, high)};
}

}  // namespace diaphane::render
