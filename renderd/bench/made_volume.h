#pragma once

#include <cstdint>
#include <string>

#include "volume/volume.h"

namespace diaphane::render::bench {

/// A head for machines that have no scan: shell, teeth, vessels as thin as a voxel, noise; mapped
/// values 0 to 30000 as the cranium's (tests/scenes), and of its extent (245 x 245 x 162 mm), so
/// that its scenes fit. `n` voxels along x and y, n * 27 / 64 along z; 16 to 2048.
volume::Volume made_volume(std::uint32_t n);

/// The same object in a cube of `n` voxels along each axis: what is measured at 256^3 to 1024^3.
volume::Volume made_cube(std::uint32_t n);

/// "made", "made:N", or a directory of the volume store. kInvalid: an N out of range.
Result<volume::Volume> named_volume(const std::string& name);

}  // namespace diaphane::render::bench
