#pragma once

#include <string>

#include "common/result.h"
#include "renderd/encode/encoder.h"

namespace diaphane::render {

// Levels by `./diaphane bench still-codecs`, docs/figures.md, "Stream: what pictures cost".
inline constexpr int kPngLevel = 1;
inline constexpr int kWebpLevel = 1;

/// RGB, rows from the top, as a PNG file (libpng, Paeth's filter on every row; level of zlib, 0 to
/// 9) or a lossless WebP file (libwebp; level 0, the quickest, to 9).
Result<std::string> encode_png(const std::string& rgb, Canvas size, int level);
Result<std::string> encode_webp(const std::string& rgb, Canvas size, int level);

}  // namespace diaphane::render
