#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "renderd/film/part.h"

// Parts of films between processes.

namespace diaphane::render {

/// Pixels in runs: a number as Protobuf writes them (varint), 2 n for n pixels that follow and
/// 2 n + 1 for one that follows and stands for n. Background costs next to nothing. A pixel is 10
/// bytes: means, halves, state, as in PackedPixel, numbers little endian.
std::string pixels_to_wire(const PackedPixel* pixels, std::size_t count);
/// kInvalid unless `bytes` are just `count` pixels.
Result<std::vector<PackedPixel>> pixels_from_wire(std::string_view bytes, std::size_t count);

/// `part` cut into bands of rows of about `most_bytes` before they are coded, each a part itself:
/// whoever gets only some of them loses nothing of those.
std::vector<FilmPart> in_bands(FilmPart part, std::size_t most_bytes);

}  // namespace diaphane::render
