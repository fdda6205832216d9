#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "renderd/kernel/views.h"
#include "volume/volume.h"

namespace diaphane::render {

/// Smallest and largest voxel value that interpolation can meet in a macrocell, half a voxel around
/// it included.
struct ValueRange {
  std::int16_t minimum, maximum;
};

/// Made once a volume; a transfer-function edit needs nothing else of the voxels. An engine that
/// keeps the ranges on its device, and bounds the cells there, leaves `ranges` empty.
struct ValueGrid {
  Int3 cells{};                          ///< macrocells along x, y, z
  std::vector<ValueRange> ranges;        ///< x fastest
  ValueRange whole{};                    ///< of all voxels
  Int3 bricks{};                         ///< of cells between voxel centres (ExactView)
  std::vector<ValueRange> brick_ranges;  ///< of the voxels at their cells' corners; x fastest
};

/// A volume is refused (kInvalid, the field named) when an axis is empty or longer than
/// kLongestAxis, when size and voxels differ, when the spacing is not finite and positive or the
/// direction is no rotation.
Result<void> check_volume(const volume::Volume& volume);
inline constexpr std::uint32_t kLongestAxis = 8192;

Int3 size_of(const volume::Header& header);

/// x fastest; `size` fits `voxels`.
ValueGrid make_value_grid(std::span<const std::int16_t> voxels, Int3 size);

}  // namespace diaphane::render
