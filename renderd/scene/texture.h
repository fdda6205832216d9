#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace diaphane::render {

/// What a texture's file may be at most, so that no scene harms another session.
inline constexpr std::size_t kMostTextureBytes = std::size_t{8} << 20;
inline constexpr std::uint32_t kLongestTexture = 4096;  ///< pixels each way

struct TextureSize {
  std::uint32_t width, height;
};

/// 8-bit sRGB, interleaved, rows from the top.
struct TexturePicture {
  TextureSize size;
  std::vector<std::uint8_t> rgb;
};

/// From the head of a PNG or JPEG file, nothing decoded. kInvalid for what is no picture or is too
/// large; kUnsupported for a format that this program was built without. Errors name no field.
Result<TextureSize> texture_size(std::string_view file);

/// The same errors, and kInvalid for a picture that is damaged. What is transparent is black, for
/// it is to give no light; 16 bits a colour are rounded to 8.
Result<TexturePicture> decode_texture(std::string_view file);

/// sRGB (IEC 61966-2-1) from 0 to 255 to linear from 0 to 1.
float linear_of(std::uint8_t srgb);

}  // namespace diaphane::render
