#pragma once

#include <cstdint>

#include "common/result.h"
#include "ingest/export/field.h"
#include "ingest/export/mesh.h"
#include "volume/volume.h"

namespace diaphane::ingest {

struct SurfaceLimits {
  std::uint64_t triangles = 1'000'000;  ///< of the result
  /// Triangles before they are decimated, which needs about 300 bytes for each.
  std::uint64_t raw_triangles = 6'000'000;
  std::uint64_t samples = std::uint64_t{1} << 28;
};

/// Returns the surface of `inside` as a closed mesh (is_closed). That of a label is smoothed,
/// because its voxels form steps. More triangles than allowed are decimated, and if that does not
/// suffice, the surface is that of a coarser grid. Returns kInvalid if no voxel is inside, or
/// kOutOfMemory.
Result<Mesh> make_surface(const volume::Volume& volume, const Inside& inside,
                          const SurfaceLimits& limits = {});

}  // namespace diaphane::ingest
