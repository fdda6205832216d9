#pragma once

#include <array>

#include "volume/volume.h"

namespace diaphane::ingest {

/// Returns the position of an index of voxels, relative to that of (0, 0, 0), in mm (LPS).
inline std::array<double, 3> step_of(const volume::Header& header,
                                     const std::array<double, 3>& index) {
  std::array<double, 3> step{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      step[row] += header.direction[3 * row + axis] * header.spacing[axis] * index[axis];
  }
  return step;
}

}  // namespace diaphane::ingest
