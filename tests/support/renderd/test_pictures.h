#pragma once

#include <cmath>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// A smooth picture of gradients and a wave, which codecs preserve well.
inline PictureRgb8 smooth_picture(std::uint32_t width, std::uint32_t height, double phase = 0) {
  PictureRgb8 picture;
  picture.size = {width, height};
  picture.pixels.reserve(std::size_t{3} * width * height);
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      picture.pixels.push_back(static_cast<std::uint8_t>(255.0 * x / width));
      picture.pixels.push_back(static_cast<std::uint8_t>(255.0 * y / height));
      picture.pixels.push_back(static_cast<std::uint8_t>(127 + 100 * std::sin(0.1 * x + phase)));
    }
  }
  return picture;
}

/// A picture of a single colour.
inline PictureRgb8 plain_picture(Canvas size, std::uint8_t red, std::uint8_t green,
                                 std::uint8_t blue) {
  PictureRgb8 picture;
  picture.size = size;
  for (std::size_t i = 0; i < std::size_t{size.width} * size.height; ++i) {
    picture.pixels.insert(picture.pixels.end(), {red, green, blue});
  }
  return picture;
}

/// Root of the mean squared difference, in 8-bit steps.
inline double rms(const PictureRgb8& a, const PictureRgb8& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    sum += std::pow(double(a.pixels[i]) - b.pixels[i], 2);
  }
  return std::sqrt(sum / double(a.pixels.size()));
}

}  // namespace diaphane::render
