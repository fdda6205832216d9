#pragma once

#include <array>
#include <optional>
#include <vector>

#include "ingest/head/coarse.h"

namespace diaphane::ingest {

/// Where the brain is, or must be: places that a cut has to keep, mm in the world of scenes.
using Brain = std::vector<std::array<double, 3>>;

/// CT: a closed shell of bone around soft tissue, of the size of a brain, over 24 mm and more.
std::optional<Brain> find_brain_case(const Coarse& coarse);

/// MR and others: a body whose cross-sections are ellipses of a head's size and that ends above in
/// a dome within the picture.
std::optional<Brain> find_head_shape(const Coarse& coarse);

}  // namespace diaphane::ingest
