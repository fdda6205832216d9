#pragma once

#include <bitset>
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

/// Which labels the macrocells contain. Computed once per volume, like ValueGrid.
struct LabelGrid {
  std::vector<std::uint32_t> numbers;  ///< numbers of the labels 1, 2, ...; empty if there are none
  /// The different sets of labels of one macrocell extended by a voxel. Bit 0 is for voxels of no
  /// label.
  std::vector<std::bitset<256>> sets;
  std::vector<std::uint32_t> set_of_cell;  ///< index in `sets`; x fastest

  bool empty() const { return numbers.empty(); }
};

/// Ranges of the voxel values. They are computed once per volume; a change of the transfer function
/// does not read the voxels again. An engine that keeps the ranges on its device and computes the
/// cells' bounds there leaves `ranges` empty.
struct ValueGrid {
  Int3 cells{};                    ///< macrocells along x, y, z
  std::vector<ValueRange> ranges;  ///< x fastest
  ValueRange whole{};              ///< range of all voxels
  Int3 bricks{};                   ///< number of bricks of cells between voxel centres (ExactView)
  /// Ranges of the voxels at the corners of their cells; x fastest.
  std::vector<ValueRange> brick_ranges;
  LabelGrid labels;
};

/// Checks a volume. Fails with kInvalid and the name of the field if an axis is empty or longer
/// than kLongestAxis, if size and number of voxels differ, if the spacing is not finite and
/// positive, if the direction is not a rotation, or if labels do not match the volume or their
/// table.
Result<void> check_volume(const volume::Volume& volume);
inline constexpr std::uint32_t kLongestAxis = 8192;

Int3 size_of(const volume::Header& header);

/// Computes the ranges of `voxels`, x fastest, whose number must match `size`.
ValueGrid make_value_grid(std::span<const std::int16_t> voxels, Int3 size);

/// Computes the labels of the macrocells. The result is empty if the set is.
LabelGrid make_label_grid(const volume::LabelSet& set, Int3 size);

}  // namespace diaphane::render
