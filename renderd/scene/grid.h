#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "renderd/kernel/views.h"
#include "volume/volume.h"

namespace diaphane::render {

/// Smallest and largest voxel value that interpolation can meet in a macrocell, half a voxel around
/// it included. Made once a volume; a transfer-function edit needs nothing else of the voxels.
struct ValueRange {
  std::int16_t minimum, maximum;
};

struct ValueGrid {
  Int3 cells{};                    ///< macrocells along x, y, z
  std::vector<ValueRange> ranges;  ///< x fastest
};

/// A volume is refused (kInvalid) when an axis is empty or longer than 4096 voxels, when size and
/// voxels differ, or when spacing or direction are not finite, not positive or not orthonormal.
Result<void> check_volume(const volume::Volume& volume);

ValueGrid make_value_grid(std::span<const std::int16_t> voxels, Int3 size);

}  // namespace diaphane::render
