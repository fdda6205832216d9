#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volume/oblique.h"
#include "volume/region.h"
#include "volume/slices.h"
#include "volume/volume.h"

namespace diaphane::volume {

/// A clipped slice has labels only where it has values, and only those of kept voxels.
struct ClippedSlice {
  const KeptVoxels& kept;
  std::span<const std::int16_t> values;  ///< of clipped_slice_of() or sample_clipped()
};

/// Returns the value of the label set (label_set.h) at each pixel of a slice of a volume with a
/// label set, 0 outside the volume. Labels are never interpolated: a sample has the label of the
/// voxel that contains it. A pixel of a slab has the label that most of its labelled samples have,
/// and of equally frequent ones the first in the table. `clipped` may be null, which means all
/// voxels.
std::vector<std::uint8_t> labels_of_slice(const Volume& volume, const SliceStack& stack,
                                          std::uint32_t index,
                                          const ClippedSlice* clipped = nullptr);
std::vector<std::uint8_t> labels_of_slice(const Volume& volume, const ObliqueSlice& slice,
                                          const ClippedSlice* clipped = nullptr);

}  // namespace diaphane::volume
