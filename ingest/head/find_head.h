#pragma once

#include <optional>
#include <string>

#include "volume/region.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// Whether a volume shows a head, judged by its voxels alone. A negative result proves nothing:
/// docs/privacy.md states its error rates.
struct HeadFinding {
  bool found = false;
  std::string sign;  ///< the sign that was found: "brain_case", "head_shape", or "none"
  /// Keeps what lies behind a plane from the brow to below the base of the skull, including the
  /// brain and its case. Set with `found` if anything lies in front of that plane.
  std::optional<volume::Region> proposal;
};

HeadFinding find_head(const volume::Volume& volume);

/// Returns {"found": ..., "sign": ..., "proposal": {"box", "planes"} or null}.
std::string to_json(const HeadFinding& finding);

}  // namespace diaphane::ingest
