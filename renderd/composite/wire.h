#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "renderd/film/part.h"

// Encoding of parts of films for transfer between processes.

namespace diaphane::render {

/// Encodes pixels in runs. Each begins with a Protobuf varint: 2 n is followed by n pixels, and 2 n
/// + 1 by one pixel that stands for n. So background takes almost no space. A pixel has 10 bytes:
/// means, halves and state as in PackedPixel, with little-endian numbers.
std::string pixels_to_wire(const PackedPixel* pixels, std::size_t count);
/// Decodes pixels. Fails with kInvalid unless `bytes` contains exactly `count` pixels.
Result<std::vector<PackedPixel>> pixels_from_wire(std::string_view bytes, std::size_t count);

/// Encodes guides as their three words, little-endian.
std::string guides_to_wire(const std::vector<PackedGuides>& guides);
/// Decodes guides. No bytes mean no guides; otherwise fails with kInvalid unless there are exactly
/// `count`.
Result<std::vector<PackedGuides>> guides_from_wire(std::string_view bytes, std::size_t count);

/// Cuts `part` into bands of rows of about `most_bytes` each before encoding. Each band is a part
/// itself, so bands that arrive are useful even if others do not.
std::vector<FilmPart> in_bands(FilmPart part, std::size_t most_bytes);

}  // namespace diaphane::render
