#pragma once

#include <string>

#include "common/result.h"
#include "renderd/scene/texture.h"

/// Environments that users have stored, by ID (docs/contracts.md, "Environments"). Whoever knows an
/// ID may light a scene with it. The directory applies to the whole process.
namespace diaphane::render {

/// Sets the directory with one file per environment. Without it, all stored environments are
/// refused.
void set_environment_directory(std::string directory);

/// Read the size or the pixels of an environment from the disk. An environment that no longer
/// exists is a single white pixel, so the light becomes uniform. Fail with kUnavailable if the disk
/// does not respond, and with kInvalid for a damaged file or if there is no directory.
Result<TextureSize> stored_size(const std::string& id);
Result<TexturePicture> load_stored(const std::string& id);

}  // namespace diaphane::render
