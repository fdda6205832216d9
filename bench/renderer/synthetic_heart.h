#pragma once

#include <cstdint>

#include "volume/volume.h"

namespace diaphane::render::bench {

/// Returns a synthetic CT of a chest with a beating heart, in Hounsfield units: skin, lungs, ribs
/// and spine that stay, and a left and a right ventricle with contrast that contract once over all
/// phases. The volume holds all phases, one after the other, each a cube of `n` voxels per axis and
/// 300 mm, and its header says "percent of a heartbeat". Precondition: `n` >= 16, `phases` >= 2.
volume::Volume synthetic_heart(std::uint32_t n, std::uint32_t phases);

}  // namespace diaphane::render::bench
