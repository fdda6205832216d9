#pragma once

#include <array>
#include <optional>
#include <vector>

#include "ingest/head/coarse.h"

namespace diaphane::ingest {

/// Where the brain is or must be: points that a cut has to keep, in mm in world space.
using Brain = std::vector<std::array<double, 3>>;

/// CT: finds a closed shell of bone around soft tissue, of the size of a brain, over at least 24
/// mm.
std::optional<Brain> find_brain_case(const Coarse& coarse);

/// MR and others: finds a body whose cross-sections are ellipses of the size of a head and that
/// ends above in a dome within the image.
std::optional<Brain> find_head_shape(const Coarse& coarse);

}  // namespace diaphane::ingest
