#include "scene/environment_import.h"

#include <algorithm>
#include <numbers>

#include "common/try.h"
#include "scene/panorama_readers.h"

namespace diaphane::scene {

PanoramaReduction::PanoramaReduction(std::uint32_t width, std::uint32_t height)
    : width_(width), height_(height) {
  const std::uint32_t divisor =
      std::max((width + kMostEnvironmentWidth - 1) / kMostEnvironmentWidth,
               (height + kMostEnvironmentHeight - 1) / kMostEnvironmentHeight);
  kept_width_ = (width + divisor - 1) / divisor;
  kept_height_ = (height + divisor - 1) / divisor;
  sums_.resize(std::size_t{kept_width_} * kept_height_);
}

void PanoramaReduction::add(std::uint32_t x, std::uint32_t y, float r, float g, float b) {
  const auto valid = [](float c) {
    if (std::isinf(c) && c > 0) return kInfinite;
    // The comparison is false for NaN.
    return c > 0 ? std::min(c, kBrightestGiven) : 0.0f;
  };
  const std::size_t i = (std::size_t{x + 1} * kept_width_ - 1) / width_;
  const std::size_t j = (std::size_t{y + 1} * kept_height_ - 1) / height_;
  Sum& sum = sums_[i + j * kept_width_];
  sum.c[0] += static_cast<double>(valid(r));
  sum.c[1] += static_cast<double>(valid(g));
  sum.c[2] += static_cast<double>(valid(b));
  ++sum.count;
}

tl::expected<EnvironmentPicture, PanoramaFault> PanoramaReduction::finish() const {
  double total = 0, weights = 0;
  for (std::uint32_t j = 0; j < kept_height_; ++j) {
    const double weight = std::sin(std::numbers::pi * (j + 0.5) / kept_height_);
    for (std::uint32_t i = 0; i < kept_width_; ++i) {
      const Sum& s = sums_[i + std::size_t{j} * kept_width_];
      if (s.count == 0) continue;
      total += weight * (0.2126 * s.c[0] + 0.7152 * s.c[1] + 0.0722 * s.c[2]) / s.count;
    }
    weights += weight * kept_width_;
  }
  if (!(total > 0)) return tl::unexpected(PanoramaFault::kBlack);
  EnvironmentPicture picture{kept_width_, kept_height_, {}};
  picture.pixels.reserve(sums_.size());
  for (const Sum& s : sums_) {
    const double scale = s.count == 0 ? 0 : weights / total / s.count;
    const auto part = [&](double c) {
      return static_cast<float>(std::min(c * scale, static_cast<double>(kBrightestPixel)));
    };
    picture.pixels.push_back(to_rgbe(part(s.c[0]), part(s.c[1]), part(s.c[2])));
  }
  return picture;
}

std::string word_of(PanoramaFault fault) {
  switch (fault) {
    case PanoramaFault::kTooLarge:
      return "too_large";
    case PanoramaFault::kFormat:
      return "format";
    case PanoramaFault::kVariant:
      return "variant";
    case PanoramaFault::kTooManyPixels:
      return "too_many_pixels";
    case PanoramaFault::kShape:
      return "shape";
    case PanoramaFault::kBlack:
      return "black";
    case PanoramaFault::kDamaged:
      break;
  }
  return "damaged";
}

std::string sentence_of(PanoramaFault fault) {
  switch (fault) {
    case PanoramaFault::kTooLarge:
      return "The file is larger than 4 MB.";
    case PanoramaFault::kFormat:
      return "The file is neither a Radiance (.hdr) nor an OpenEXR (.exr) picture.";
    case PanoramaFault::kVariant:
      return "This variant of the format is not supported. Save the picture with the channels R, G "
             "and B, in lines, and with the compression ZIP, PIZ, RLE or none.";
    case PanoramaFault::kTooManyPixels:
      return "The picture has more than 4096 x 2048 pixels.";
    case PanoramaFault::kShape:
      return "The picture is not a panorama of all directions, which is twice as wide as high.";
    case PanoramaFault::kBlack:
      return "The picture gives no light, because it is black.";
    case PanoramaFault::kDamaged:
      break;
  }
  return "The file is damaged.";
}

std::optional<PanoramaFault> fault_of_size(std::uint64_t width, std::uint64_t height) {
  if (width == 0 || height == 0) return PanoramaFault::kDamaged;
  if (width > kMostPanoramaWidth || height > kMostPanoramaHeight) {
    return PanoramaFault::kTooManyPixels;
  }
  // Some programs round one of the sides.
  const std::uint64_t twice = 2 * height;
  const std::uint64_t difference = width > twice ? width - twice : twice - width;
  if (difference > 1 + width / 100) return PanoramaFault::kShape;
  return {};
}

tl::expected<EnvironmentPicture, PanoramaFault> import_panorama(std::string_view file) {
  if (file.size() > kMostPanoramaBytes) return tl::unexpected(PanoramaFault::kTooLarge);
  if (is_radiance(file)) return read_radiance(file);
  if (file.starts_with("\x76\x2f\x31\x01")) return read_exr(file);
  return tl::unexpected(PanoramaFault::kFormat);
}

}  // namespace diaphane::scene
