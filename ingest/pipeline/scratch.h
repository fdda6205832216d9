#pragma once

#include <cstddef>
#include <string>

namespace diaphane::ingest {

/// Removes voxel files that a killed process left in the scratch directory (only on file systems
/// without unnamed files do they have a name at all, and for an instant). How many.
std::size_t sweep_scratch(const std::string& directory);

/// True when a file can be made in `directory`.
bool can_write(const std::string& directory);

}  // namespace diaphane::ingest
