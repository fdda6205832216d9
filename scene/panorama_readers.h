#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "scene/environment_import.h"

// Parts of import_panorama().

namespace diaphane::scene {

/// Replaces an infinite component: the largest half-precision number.
inline constexpr float kInfinite = 65504.0f;
/// The largest component that is averaged, in the file's own units.
inline constexpr float kBrightestGiven = 1e12f;

/// Averages pixels to the size that is stored, and scales the result.
class PanoramaReduction {
 public:
  PanoramaReduction(std::uint32_t width, std::uint32_t height);
  /// Adds a pixel, which may have any numbers. Each pixel must be added once.
  void add(std::uint32_t x, std::uint32_t y, float r, float g, float b);
  tl::expected<EnvironmentPicture, PanoramaFault> finish() const;

 private:
  struct Sum {
    double c[3] = {};
    std::uint32_t count = 0;
  };
  std::uint32_t width_, height_, kept_width_ = 0, kept_height_ = 0;
  std::vector<Sum> sums_;
};

std::optional<PanoramaFault> fault_of_size(std::uint64_t width, std::uint64_t height);

tl::expected<EnvironmentPicture, PanoramaFault> read_radiance(std::string_view file);
/// Reads an OpenEXR panorama. Fails with kFormat in a build without tinyexr.
tl::expected<EnvironmentPicture, PanoramaFault> read_exr(std::string_view file);

}  // namespace diaphane::scene
