#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "api/proto/stream.pb.h"
#include "common/result.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

inline constexpr std::uint32_t kTileSide = 256;

/// A part of a picture, in pixels.
struct Tile {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;

  bool operator==(const Tile&) const = default;
};

/// Returns tiles of 256 x 256 that cover a picture once, row by row from the top left. Tiles at the
/// right and lower border are smaller.
std::vector<Tile> plan_tiles(Canvas size);

struct CodedTile {
  diaphane::v1::StillFormat format = diaphane::v1::STILL_FORMAT_UNSPECIFIED;
  std::string data;  ///< a file of that format, RGB without alpha or colour profile
  std::string hash;  ///< 32-byte SHA-256 of the pixels: RGB, rows from the top
};

/// Encodes a part of a picture losslessly. Fails with kInternal if the picture does not contain it.
Result<CodedTile> encode_tile(const PictureRgb8& picture, const Tile& tile,
                              diaphane::v1::StillFormat format);

}  // namespace diaphane::render
