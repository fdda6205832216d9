#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::volume {

/// Prefix of the names of unfinished files and directories.
inline constexpr const char* kTemporaryPrefix = ".tmp-";
/// Folder of the volume store for the environments of users, `<id>.hdr` (scene/environment_file.h).
inline constexpr const char* kEnvironments = "environments";

/// Removes the directories `.tmp-…` that killed writers left in the volume store: unfinished
/// volumes, and old ones that had been replaced. Directories that a running writer has locked stay.
/// Any program may call it at any time. Returns the number of removed directories, or kUnavailable
/// if `store` cannot be listed.
Result<std::size_t> sweep_unfinished(const std::string& store);

/// Returns the content hash of the volume in `directory`, or an empty string if there is certainly
/// no volume. Returns nullopt if the header cannot be read, for example because the disk does not
/// respond.
std::optional<std::string> stored_hash(const std::string& directory);
/// Like stored_hash, for the version of the volume (version_of).
std::optional<std::string> stored_version(const std::string& directory);
/// Returns the content hash of a volume and, if it has labels, a space and their hash.
std::string version_of(const Header& header);

/// Truncates the files of a volume and removes its directory. Failures are ignored.
void erase(const std::string& directory);

}  // namespace diaphane::volume
