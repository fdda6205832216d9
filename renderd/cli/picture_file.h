#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/result.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::cli {

enum class PictureFormat {
  kPng,  ///< 8 bits, tone-mapped
  kPpm,  ///< 8 bits, tone-mapped, uncompressed; needs no library
  kExr,  ///< linear radiance, 32-bit float, ZIP
};

/// Returns the format for a file name's extension, or nullopt.
std::optional<PictureFormat> picture_format(std::string_view path);

/// Returns why a picture cannot be written with `path`'s extension: the extension is unknown, or
/// this program was built without the library for it.
std::optional<std::string> unwritable_picture(std::string_view path);

/// Return the bytes of the file. Fail with kUnsupported if this program was built without the
/// library, and with kInternal and the library's message otherwise.
Result<std::string> encode_png(const PictureRgb8& picture);
std::string encode_ppm(const PictureRgb8& picture);
Result<std::string> encode_exr(const PictureRgbF& picture);

/// Writes to a temporary file and renames it, so that an existing file stays complete until then.
/// Fails with kForbidden and the system's message.
Result<void> write_file(const std::string& path, std::string_view bytes);

}  // namespace diaphane::render::cli
