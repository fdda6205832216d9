#pragma once

#include <cstdint>

namespace diaphane::render {

/// Size of a picture in pixels; each of 1 .. kLongestCanvas. It may be a band of rows of a larger
/// one: then its pixels are that one's, bit by bit, wherever they are rendered.
struct Canvas {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t first_row = 0;     ///< in the picture that it is a band of
  std::uint32_t whole_height = 0;  ///< of that picture; 0: it is a picture by itself

  std::uint32_t picture_height() const { return whole_height == 0 ? height : whole_height; }
  bool operator==(const Canvas&) const = default;
};
inline constexpr std::uint32_t kLongestCanvas = 16384;
inline constexpr std::uint64_t kMostCanvasPixels = std::uint64_t{1} << 26;  ///< of one film

/// Whether a film can be made of it.
inline bool is_sound(Canvas canvas) {
  return canvas.width > 0 && canvas.height > 0 && canvas.width <= kLongestCanvas &&
         canvas.picture_height() <= kLongestCanvas &&
         std::uint64_t{canvas.width} * canvas.height <= kMostCanvasPixels &&
         canvas.first_row <= canvas.picture_height() &&
         canvas.height <= canvas.picture_height() - canvas.first_row;
}

}  // namespace diaphane::render
