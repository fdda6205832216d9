#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "volume/volume.h"

namespace diaphane::ingest {

/// What a surface encloses.
struct Inside {
  /// Encloses the voxels with this value in the label set; 0: those with at least `above`.
  std::uint8_t label = 0;
  std::int16_t above = 0;
};

/// Samples around what a surface encloses: positive inside and negative outside. All samples at the
/// border are outside, so that the surface is closed where it would leave the scan.
struct Field {
  std::array<std::uint32_t, 3> size{};
  std::array<double, 3> first{};  ///< index in the volume of the centre of sample (0, 0, 0)
  std::uint32_t step = 1;         ///< voxels per sample along each axis
  std::vector<std::int16_t> samples;
};

/// Returns the samples, each the mean of `step`³ voxels, with a larger step if there would be more
/// than `most`. nullopt: no voxel is inside.
std::optional<Field> sample_field(const volume::Volume& volume, const Inside& inside,
                                  std::uint32_t step, std::uint64_t most);

/// Returns the number of points of the surface, one on each edge of the grid that it crosses. It
/// has about twice as many triangles.
std::uint64_t crossings(const Field& field);

}  // namespace diaphane::ingest
