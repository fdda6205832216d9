#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "api/proto/scene.pb.h"
#include "common/result.h"
#include "renderd/scene/light_textures.h"

/// The memory of this process for decoded textures. One for the process, as the memory that it
/// bounds: sessions, stills, films and pictures of other workers all decode textures.
namespace diaphane::render {

/// Bytes for the textures of all scenes together, unless limit_texture_memory says otherwise:
/// three scenes with the largest ones.
inline constexpr std::size_t kTextureMemory = std::size_t{1} << 30;
/// Of that, what one owner's scenes may take together: the largest textures and, while they are
/// replaced, those before.
inline constexpr std::size_t kOwnersTextureMemory = kTextureMemory / 8 * 5;
/// Pixels of the textures of a visitor's scene in all, a sixteenth of anybody else's: 17 MB.
inline constexpr std::size_t kMostVisitorTexels = std::size_t{1024} * 1024;

/// `owners`: of one owner.
void limit_texture_memory(std::size_t all, std::size_t owners);
/// Taken now.
std::size_t texture_memory();
/// Given back since the last call.
std::size_t take_freed_texture_memory();

/// What the pictures on the lights of a scene take once decoded, with their files; nothing is
/// decoded for it. Errors name the field.
Result<std::size_t> bytes_of_textures(const std::vector<TextureFile>& files);
/// kInvalid, naming the field: more pixels in all than a visitor's scene may have.
Result<void> check_visitors_textures(const std::vector<TextureFile>& files);

/// As prepare_textures, for `owner` (empty: nobody in particular, bounded by what all may take).
/// The same files that another scene has are shared with it and cost nothing. kTooMany, naming the
/// field, before anything is decoded: there is no memory for them.
Result<std::shared_ptr<const PreparedTextures>> prepare_textures_for(
    const std::string& owner, const std::vector<TextureFile>& files,
    const std::shared_ptr<const PreparedTextures>& before);

/// The pictures on those lights of a scene that give light.
std::vector<TextureFile> texture_files(const diaphane::v1::Scene& scene);

}  // namespace diaphane::render
