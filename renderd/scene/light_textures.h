#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "renderd/kernel/views.h"

namespace diaphane::render {

/// The pictures on a scene's lights as a kernel reads them (LightsView), one entry a different
/// file.
struct PreparedTextures {
  std::vector<std::string> files;  ///< what each was decoded from
  std::vector<LightTexture> textures;
  std::vector<Double3> means;      ///< colour of each, over its area
  std::vector<Double3> sky_means;  ///< over the solid angle, as a latitude-longitude map
  std::vector<Float4> texels;
  std::vector<float> rows;
};

/// Pixels that the textures of a scene may have in all: one of the largest size, 270 MB.
inline constexpr std::size_t kMostTexels = std::size_t{4096} * 4096;

/// A file and the field of the scene that it comes from.
struct TextureFile {
  const std::string* file;
  std::string field;
};

/// `files` may repeat; nothing for none. `before`, the textures of the scene before, is returned
/// again when the files are the same, and what it has decoded is taken from it. kInvalid and
/// kUnsupported name the field.
Result<std::shared_ptr<const PreparedTextures>> prepare_textures(
    const std::vector<TextureFile>& files, const std::shared_ptr<const PreparedTextures>& before);

/// Index of a file that was prepared.
std::uint32_t texture_index(const PreparedTextures& textures, const std::string& file);

}  // namespace diaphane::render
