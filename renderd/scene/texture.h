#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "scene/environment_file.h"

namespace diaphane::render {

/// Limits of a texture file, so that no scene harms other sessions.
inline constexpr std::size_t kMostTextureBytes = std::size_t{8} << 20;
inline constexpr std::uint32_t kLongestTexture = 4096;  ///< pixels per side

struct TextureSize {
  std::uint32_t width, height;
  friend bool operator==(const TextureSize&, const TextureSize&) = default;
};

/// A decoded picture in one of two forms. The rows begin at the top.
struct TexturePicture {
  TextureSize size;
  std::vector<std::uint8_t> rgb;  ///< 8-bit sRGB, interleaved
  std::vector<scene::Rgbe> rgbe;  ///< radiances
};

/// Reads the size from the header of a PNG or JPEG file, or of an environment in its stored form
/// (scene/environment_file.h), without decoding it. Fails with kInvalid for a file that is not such
/// a picture or is too large, and with kUnsupported for a format that this build does not contain.
/// Errors do not name a field.
Result<TextureSize> texture_size(std::string_view file);

/// Decodes a picture. Fails like texture_size(), and with kInvalid for a damaged file. Transparent
/// pixels become black, because they must not emit light. 16 bits per colour are rounded to 8.
Result<TexturePicture> decode_texture(std::string_view file);

/// Returns the linear values from 0 to 1 of the sRGB values (IEC 61966-2-1) from 0 to 255.
const std::array<float, 256>& linear_of_srgb();

}  // namespace diaphane::render
