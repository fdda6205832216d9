#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "scene/environment_file.h"

/// Turns a user's panorama into the form in which environments are stored. A server must call this
/// in a sandbox, because libraries parse the file.
namespace diaphane::scene {

inline constexpr std::size_t kMostPanoramaBytes = std::size_t{4} << 20;
/// Limits of the picture before it is reduced. The memory that decoding takes follows from them.
inline constexpr std::uint32_t kMostPanoramaWidth = 4096, kMostPanoramaHeight = 2048;
inline constexpr int kMostPanoramaChannels = 4;

enum class PanoramaFault { kTooLarge, kFormat, kVariant, kDamaged, kTooManyPixels, kShape, kBlack };

/// Returns the fault as a word for machines ("too_many_pixels") and as a sentence.
std::string word_of(PanoramaFault fault);
std::string sentence_of(PanoramaFault fault);

/// Reads a Radiance (.hdr) or OpenEXR (.exr) panorama: longitude from left to right, latitude from
/// top to bottom. It is reduced to at most 1024 x 512 pixels and scaled so that its mean luminance
/// over all directions is 1. Negative components and those that are not a number become 0, infinite
/// ones the largest half-precision number, and larger ones 10^12. What is above kBrightestPixel
/// after the scaling is cut off there.
tl::expected<EnvironmentPicture, PanoramaFault> import_panorama(std::string_view file);

}  // namespace diaphane::scene
