#pragma once

#include <cstdint>
#include <string>

#include "volume/volume.h"

namespace diaphane::render::bench {

/// Returns a synthetic head for machines without a scan, with a shell, teeth, vessels as thin as a
/// voxel, and noise. Its mapped values 0 to 30000 and its extent (245 x 245 x 162 mm) are those of
/// the cranium, so that the scenes of tests/scenes fit. It has `n` voxels along x and y and n * 27
/// / 64 along z, with n from 16 to 2048.
volume::Volume synthetic_volume(std::uint32_t n);

/// Returns the same object in a cube of `n` voxels per axis, for measurements from 256^3 to 1024^3.
volume::Volume synthetic_cube(std::uint32_t n);

/// Loads "made", "made:N", or a directory of the volume store. Returns kInvalid if N is out of
/// range.
Result<volume::Volume> named_volume(const std::string& name);

}  // namespace diaphane::render::bench
