#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "renderd/kernel/views.h"
#include "volume/volume.h"

namespace diaphane::render {

/// Smallest and largest voxel value that interpolation can use in a macrocell extended by half a
/// voxel.
struct ValueRange {
  std::int16_t minimum, maximum;
};

/// Ranges of the voxel values. They are computed once per volume; a change of the transfer function
/// does not read the voxels again. An engine that keeps the ranges on its device and computes the
/// cells' bounds there leaves `ranges` empty.
struct ValueGrid {
  Int3 cells{};                    ///< macrocells along x, y, z
  std::vector<ValueRange> ranges;  ///< x fastest
  ValueRange whole{};              ///< of all voxels
  Int3 bricks{};                   ///< number of bricks of cells between voxel centres (ExactView)
  /// Ranges of the voxels at the corners of their cells; x fastest.
  std::vector<ValueRange> brick_ranges;
};

/// Checks a volume. Fails with kInvalid and the name of the field if an axis is empty or longer
/// than kLongestAxis, if size and number of voxels differ, if the spacing is not finite and
/// positive, or if the direction is not a rotation.
Result<void> check_volume(const volume::Volume& volume);
inline constexpr std::uint32_t kLongestAxis = 8192;

Int3 size_of(const volume::Header& header);

/// Computes the ranges of `voxels`, x fastest, whose number must match `size`.
ValueGrid make_value_grid(std::span<const std::int16_t> voxels, Int3 size);

}  // namespace diaphane::render
