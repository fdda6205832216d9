#pragma once

#include <string>

#include "common/result.h"
#include "renderd/encode/encoder.h"

namespace diaphane::render {

// Levels chosen with `./diaphane bench still-codecs` (docs/figures/still-codecs.json).
inline constexpr int kPngLevel = 1;
inline constexpr int kWebpLevel = 1;

/// Encodes RGB, rows from the top, as a PNG file (libpng, Paeth filter on every row, zlib level 0
/// to 9) or as a lossless WebP file (libwebp, level 0, the fastest, to 9). Return kInternal if the
/// library fails.
Result<std::string> encode_png(const std::string& rgb, Canvas size, int level);
Result<std::string> encode_webp(const std::string& rgb, Canvas size, int level);

}  // namespace diaphane::render
