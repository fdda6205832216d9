#pragma once

#include <array>
#include <optional>
#include <vector>

#include "ingest/head/coarse.h"

namespace diaphane::ingest {

/// Points of the brain, found or estimated, in mm in world space. A cut has to keep them.
using Brain = std::vector<std::array<double, 3>>;

/// Finds the brain in a CT: soft tissue of the size of a brain within a closed shell of bone, over
/// at least 24 mm.
std::optional<Brain> find_brain_case(const Coarse& coarse);

/// Estimates the brain in MR and others, in a body whose cross-sections are ellipses of the size of
/// a head and which ends above in a dome within the image.
std::optional<Brain> find_head_shape(const Coarse& coarse);

}  // namespace diaphane::ingest
