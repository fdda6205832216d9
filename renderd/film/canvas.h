#pragma once

#include <cstdint>

namespace diaphane::render {

/// Size of a picture in pixels; each of 1 .. kLongestCanvas.
struct Canvas {
  std::uint32_t width = 0;
  std::uint32_t height = 0;

  bool operator==(const Canvas&) const = default;
};
inline constexpr std::uint32_t kLongestCanvas = 8192;

}  // namespace diaphane::render
