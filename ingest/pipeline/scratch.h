#pragma once

#include <cstddef>
#include <string>

namespace diaphane::ingest {

/// Removes voxel files that a killed process left in the scratch directory, and returns their
/// number. Such files have a name, briefly, only on file systems without unnamed files.
std::size_t sweep_scratch(const std::string& directory);

/// Returns whether a file can be created in `directory`.
bool can_write(const std::string& directory);

}  // namespace diaphane::ingest
