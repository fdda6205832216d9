#pragma once

#include <cstdint>

namespace diaphane::render {

/// The size of a picture in pixels; both sides are 1 to kLongestCanvas. A canvas may be a band of
/// rows of a larger picture, whose pixels it reproduces bit for bit.
struct Canvas {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t first_row = 0;     ///< row of the whole picture where the band begins
  std::uint32_t whole_height = 0;  ///< height of the whole picture; 0 if this is not a band

  std::uint32_t picture_height() const { return whole_height == 0 ? height : whole_height; }
  double pixels() const { return double(width) * double(height); }
  bool operator==(const Canvas&) const = default;
};
inline constexpr std::uint32_t kLongestCanvas = 16384;
/// The maximum number of pixels of one film.
inline constexpr std::uint64_t kMostCanvasPixels = std::uint64_t{1} << 26;

/// Returns whether a film can have this canvas.
inline bool is_sound(Canvas canvas) {
  return canvas.width > 0 && canvas.height > 0 && canvas.width <= kLongestCanvas &&
         canvas.picture_height() <= kLongestCanvas &&
         std::uint64_t{canvas.width} * canvas.height <= kMostCanvasPixels &&
         canvas.first_row <= canvas.picture_height() &&
         canvas.height <= canvas.picture_height() - canvas.first_row;
}

}  // namespace diaphane::render
