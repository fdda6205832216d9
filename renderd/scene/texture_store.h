#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "api/proto/scene.pb.h"
#include "common/result.h"
#include "renderd/scene/light_textures.h"

/// The memory of this process for decoded textures. The limit applies to the whole process, because
/// sessions, stills, files and pictures for other workers all decode textures.
namespace diaphane::render {

/// Limit in bytes for the textures of all scenes together, unless limit_texture_memory() changes
/// it: three scenes with the largest textures.
inline constexpr std::size_t kTextureMemory = std::size_t{1} << 30;
/// Part of that limit for the scenes of one owner: the largest textures and, while they are
/// replaced, the previous ones.
inline constexpr std::size_t kOwnersTextureMemory = kTextureMemory / 8 * 5;
/// Maximum total number of pixels of the textures of a visitor's scene, a sixteenth of the usual
/// limit: 17 MB.
inline constexpr std::size_t kMostVisitorTexels = std::size_t{1024} * 1024;

/// Sets the limits in bytes for all scenes and for one owner.
void limit_texture_memory(std::size_t all, std::size_t owners);
/// Returns the bytes in use.
std::size_t texture_memory();
/// Returns the bytes freed since the last call.
std::size_t take_freed_texture_memory();

/// Returns the bytes that the pictures on a scene's lights take when decoded, including their
/// files. Decodes nothing. Errors name the field.
Result<std::size_t> bytes_of_textures(const std::vector<TextureFile>& files);
/// Checks the textures of a visitor's scene. Fails with kInvalid and the name of the field if they
/// have too many pixels.
Result<void> check_visitors_textures(const std::vector<TextureFile>& files);

/// Like prepare_textures(), for `owner`. If that is empty, only the limit for all scenes applies.
/// Files that another scene already has are shared with it at no cost. Fails with kTooMany and the
/// name of the field, before anything is decoded, if the limit would be exceeded.
Result<std::shared_ptr<const PreparedTextures>> prepare_textures_for(
    const std::string& owner, const std::vector<TextureFile>& files,
    const std::shared_ptr<const PreparedTextures>& before);

/// Returns the pictures on those lights of a scene that give light.
std::vector<TextureFile> texture_files(const diaphane::v1::Scene& scene);

}  // namespace diaphane::render
