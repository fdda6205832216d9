#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#if defined(DIAPHANE_HAVE_PNG)
#include <png.h>
#endif

// Pictures for the tests of lights. They are empty if PNG was not found, and those tests are
// skipped then.

namespace diaphane::render::test {

struct Rgb8 {
  std::uint8_t r, g, b;
};

/// Encodes a PNG file; `colour(i, j)` counts from the upper left.
inline std::string png(std::uint32_t width, std::uint32_t height,
                       const std::function<Rgb8(std::uint32_t, std::uint32_t)>& colour) {
#if defined(DIAPHANE_HAVE_PNG)
  std::vector<std::uint8_t> rgb;
  for (std::uint32_t j = 0; j < height; ++j) {
    for (std::uint32_t i = 0; i < width; ++i) {
      const Rgb8 c = colour(i, j);
      rgb.insert(rgb.end(), {c.r, c.g, c.b});
    }
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  png_image_write_to_memory(&image, nullptr, &size, 0, rgb.data(), 0, nullptr);
  std::string file(size, '\0');
  png_image_write_to_memory(&image, file.data(), &size, 0, rgb.data(), 0, nullptr);
  file.resize(size);
  return file;
#else
  (void)width;
  (void)height;
  (void)colour;
  return {};
#endif
}

}  // namespace diaphane::render::test
