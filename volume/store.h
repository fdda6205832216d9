#pragma once

#include <cstddef>
#include <string>

#include "common/result.h"

namespace diaphane::volume {

/// Removes what writers that were killed left in the volume store: directories `.tmp-…` that no
/// living writer holds locked, be they new ones or old ones that were exchanged. Any program may do
/// so at any time. Returns how many. kUnavailable when `store` cannot be listed.
Result<std::size_t> sweep_unfinished(const std::string& store);

/// Removes a volume's directory, its files emptied first. What cannot be removed stays.
void erase(const std::string& directory);

}  // namespace diaphane::volume
