#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

/// The only form in which environments are stored and reach the renderer: a Radiance picture
/// without compression, which needs no library to read and has only finite radiances that are not
/// negative.
namespace diaphane::scene {

/// Size of the largest stored environment. Finer details do not change the light visibly.
inline constexpr std::uint32_t kMostEnvironmentWidth = 1024, kMostEnvironmentHeight = 512;
inline constexpr std::size_t kMostEnvironmentBytes =
    std::size_t{4} * kMostEnvironmentWidth * kMostEnvironmentHeight + 64;
/// The largest exponent byte of a pixel, and the largest radiance: about 10^6, as of the sun.
inline constexpr std::uint8_t kMostExponent = 128 + 20;
inline constexpr float kBrightestPixel = 1048576.0f * 255 / 256;

/// A pixel: red, green, blue and their common exponent (Ward, "Real Pixels", Graphics Gems II).
using Rgbe = std::array<std::uint8_t, 4>;

struct EnvironmentPicture {
  std::uint32_t width = 0, height = 0;
  std::vector<Rgbe> pixels;  ///< rows from the top
};

/// Rounds a pixel to the nearest value. Components must be from 0 to kBrightestPixel.
Rgbe to_rgbe(float r, float g, float b);

/// Returns the radiance of a component of a pixel.
inline float radiance_of(const Rgbe& pixel, std::size_t component) {
  return pixel[3] == 0 ? 0.0f : std::ldexp(static_cast<float>(pixel[component]), pixel[3] - 136);
}

/// Returns whether a file claims to be a Radiance picture.
inline bool is_radiance(std::string_view file) {
  return file.starts_with("#?RADIANCE") || file.starts_with("#?RGBE");
}

/// Returns width and height. Fails with kInvalid for any other form, even of Radiance pictures.
Result<std::array<std::uint32_t, 2>> environment_size(std::string_view file);
/// Reads an environment. Fails like environment_size(), and for pixels that are too bright.
Result<EnvironmentPicture> read_environment(std::string_view file);
std::string write_environment(const EnvironmentPicture& picture);

}  // namespace diaphane::scene
