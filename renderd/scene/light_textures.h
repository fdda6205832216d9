#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "renderd/kernel/views.h"
#include "renderd/scene/texture.h"

namespace diaphane::render {

/// The pictures on a scene's lights as a kernel reads them (LightsView). Each distinct file has one
/// entry.
struct PreparedTextures {
  std::vector<std::string> files;  ///< the file of each entry, or the ID of a stored environment
  std::vector<LightTexture> textures;
  std::vector<Double3> means;      ///< mean colour of each over its area
  std::vector<Double3> sky_means;  ///< mean over the solid angle, as a latitude-longitude map
  std::vector<Float4> texels;
  std::vector<float> rows;
};

/// Maximum total number of pixels of a scene's textures: one texture of the largest size, or eight
/// of kKeptTexels, which take 270 MB.
inline constexpr std::size_t kMostTexels = std::size_t{4096} * 4096;
/// A larger picture is reduced to at most this number of texels. Finer details would not change the
/// lighting visibly, and the largest picture would take 270 MB and 0.6 s of CPU time.
inline constexpr std::size_t kKeptTexels = std::size_t{2048} * 1024;

/// Returns the size at which a picture is kept: both sides are divided by the smallest integer with
/// which it has at most kKeptTexels, and rounded up.
TextureSize kept_size(TextureSize size);

/// A file and the field of the scene that it comes from.
struct TextureFile {
  const std::string* file;
  std::string field;
  bool stored = false;  ///< `file` is the ID of a stored environment (environment_store.h)
};

/// Decodes textures. `files` may contain duplicates; the result is null if there are none. `before`
/// has the textures of the previous scene: it is returned if the files are the same, and otherwise
/// its decoded textures are reused. Fails with kInvalid or kUnsupported and the name of the field.
Result<std::shared_ptr<const PreparedTextures>> prepare_textures(
    const std::vector<TextureFile>& files, const std::shared_ptr<const PreparedTextures>& before);

/// Returns the index of a file that has been prepared.
std::uint32_t texture_index(const PreparedTextures& textures, const std::string& file);

}  // namespace diaphane::render
