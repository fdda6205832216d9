#pragma once

#include <optional>
#include <string>

#include "volume/region.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// Whether a volume shows a head, judged by its voxels alone. A "no" proves nothing:
/// docs/privacy.md says how often it is wrong on what.
struct HeadFinding {
  bool found = false;
  std::string sign;  ///< by what: "brain_case", "head_shape"; else "none"
  /// Keeps what lies behind a plane from the brow to below the skull's base, the brain and its case
  /// with it; with `found`, and when there is anything in front of that plane.
  std::optional<volume::Region> proposal;
};

HeadFinding find_head(const volume::Volume& volume);

/// {"found": ..., "sign": ..., "proposal": {"box", "planes"} or null}
std::string to_json(const HeadFinding& finding);

}  // namespace diaphane::ingest
