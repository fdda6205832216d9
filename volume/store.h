#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "common/result.h"

namespace diaphane::volume {

/// Removes what writers that were killed left in the volume store: directories `.tmp-…` that no
/// living writer holds locked, be they new ones or old ones that were exchanged. Any program may do
/// so at any time. Returns how many. kUnavailable when `store` cannot be listed.
Result<std::size_t> sweep_unfinished(const std::string& store);

/// The content hash of the volume that is in `directory` now, empty when there is none; nullopt
/// when a disk that does not answer cannot say: only a file that is surely gone, or says otherwise,
/// is.
std::optional<std::string> stored_hash(const std::string& directory);

/// Removes a volume's directory, its files emptied first. What cannot be removed stays.
void erase(const std::string& directory);

}  // namespace diaphane::volume
