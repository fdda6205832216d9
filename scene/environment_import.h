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
/// Limits of the picture before it is reduced, which bound the memory that decoding takes.
inline constexpr std::uint32_t kMostPanoramaWidth = 4096, kMostPanoramaHeight = 2048;
inline constexpr int kMostPanoramaChannels = 4;

enum class PanoramaFault { kTooLarge, kFormat, kVariant, kDamaged, kTooManyPixels, kShape, kBlack };

/// Returns the fault as a word for machines ("too_many_pixels") and as a sentence.
std::string word_of(PanoramaFault fault);
std::string sentence_of(PanoramaFault fault);

/// Reads a Radiance (.hdr) or OpenEXR (.exr) panorama: longitude from left to right, latitude from
/// top to bottom. Reduces it to at most 1024 x 512 pixels and scales it so that its mean luminance
/// over all directions is 1. Components that are negative or NaN become 0, infinite ones the
/// largest half-precision number, and those above 10^12 become 10^12. After scaling, components are
/// clamped to kBrightestPixel.
tl::expected<EnvironmentPicture, PanoramaFault> import_panorama(std::string_view file);

}  // namespace diaphane::scene
