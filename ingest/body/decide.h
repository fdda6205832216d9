#pragma once

#include <cstdint>
#include <vector>

#include "ingest/body/cells.h"
#include "ingest/body/surface.h"
#include "ingest/body/values.h"

namespace diaphane::ingest {

enum class CellKind : std::uint8_t {
  kAir,
  kSkin,     ///< voxels of matter belong to the body
  kInside,   ///< the whole cell belongs to the body
  kCut,      ///< voxels of matter in front of all surfaces belong to the body
  kSupport,  ///< voxels of matter belong to a support
};

struct Decision {
  std::vector<CellKind> kinds;
  std::vector<Surface> surfaces;
  bool has_support = false;
};

/// Decides for each cell whether it shows the body or its support.
Decision decide(const volume::Volume& volume, const Cells& cells, const ValueScale& scale);

}  // namespace diaphane::ingest
