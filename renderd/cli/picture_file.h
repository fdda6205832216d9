#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/result.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::cli {

enum class PictureFormat {
  kPng,  ///< 8 bits, tone-mapped
  kPpm,  ///< likewise, uncompressed; needs no library
  kExr,  ///< linear radiance, 32-bit float, ZIP
};

/// By the file name's ending, or nothing.
std::optional<PictureFormat> picture_format(std::string_view path);

/// Why a picture cannot be written as `path`'s ending says: unknown, or this program was built
/// without its library.
std::optional<std::string> unwritable_picture(std::string_view path);

/// The file's bytes. kUnsupported when built without the library; kInternal with the library's
/// message.
Result<std::string> encode_png(const PictureRgb8& picture);
std::string encode_ppm(const PictureRgb8& picture);
Result<std::string> encode_exr(const PictureRgbF& picture);

/// Writes under a temporary name and renames, so that an old file stays whole until the new one is.
/// kForbidden says what the system said.
Result<void> write_file(const std::string& path, std::string_view bytes);

}  // namespace diaphane::render::cli
