#include "renderd/encode/tiles.h"

#include <sodium.h>
#include <webp/encode.h>

#include <algorithm>
#include <array>
#include <memory>

#include "common/try.h"
#include "renderd/encode/png_rows.h"
#include "renderd/encode/tile_codecs.h"

namespace diaphane::render {
namespace {

// Copies the pixels of a tile into contiguous rows, as they are hashed.
std::string cut(const PictureRgb8& picture, const Tile& tile) {
  std::string pixels;
  pixels.reserve(std::size_t{3} * tile.width * tile.height);
  for (std::uint32_t y = tile.y; y < tile.y + tile.height; ++y) {
    const auto* row =
        picture.pixels.data() + std::size_t{3} * (std::size_t{y} * picture.size.width + tile.x);
    pixels.append(reinterpret_cast<const char*>(row), std::size_t{3} * tile.width);
  }
  return pixels;
}

std::string sha256(const std::string& bytes) {
  std::array<unsigned char, crypto_hash_sha256_BYTES> hash{};
  crypto_hash_sha256(hash.data(), reinterpret_cast<const unsigned char*>(bytes.data()),
                     bytes.size());
  return {reinterpret_cast<const char*>(hash.data()), hash.size()};
}

}  // namespace

std::vector<Tile> plan_tiles(Canvas size) {
  std::vector<Tile> tiles;
  for (std::uint32_t y = 0; y < size.height; y += kTileSide) {
    for (std::uint32_t x = 0; x < size.width; x += kTileSide) {
      tiles.push_back(
          {x, y, std::min(kTileSide, size.width - x), std::min(kTileSide, size.height - y)});
    }
  }
  return tiles;
}

Result<std::string> encode_png(const std::string& rgb, Canvas size, int level) {
  auto rows = make_png_rows(size, level);
  DIAPHANE_TRY(rows);
  auto file = (*rows)->add({reinterpret_cast<const std::uint8_t*>(rgb.data()), rgb.size()});
  if (!file) return file;
  auto end = (*rows)->finish();
  if (!end) return end;
  *file += *end;
  return file;
}

Result<std::string> encode_webp(const std::string& rgb, Canvas size, int level) {
  WebPConfig config;
  WebPPicture picture;
  if (!WebPConfigInit(&config) || !WebPConfigLosslessPreset(&config, level) ||
      !WebPPictureInit(&picture)) {
    return fail(ErrorCode::kInternal,
                "The version of libwebp differs from the one that the server was built with.");
  }
  const std::unique_ptr<WebPPicture, void (*)(WebPPicture*)> free_picture(&picture,
                                                                          WebPPictureFree);
  WebPMemoryWriter written;
  WebPMemoryWriterInit(&written);
  const std::unique_ptr<WebPMemoryWriter, void (*)(WebPMemoryWriter*)> free_written(
      &written, WebPMemoryWriterClear);
  picture.use_argb = 1;
  picture.width = static_cast<int>(size.width);
  picture.height = static_cast<int>(size.height);
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &written;
  const auto* pixels = reinterpret_cast<const std::uint8_t*>(rgb.data());
  if (!WebPPictureImportRGB(&picture, pixels, static_cast<int>(3 * size.width)) ||
      !WebPEncode(&config, &picture)) {
    return fail(ErrorCode::kInternal, "An image could not be encoded as WebP.");
  }
  return std::string(reinterpret_cast<const char*>(written.mem), written.size);
}

Result<CodedTile> encode_tile(const PictureRgb8& picture, const Tile& tile,
                              v1::StillFormat format) {
  DIAPHANE_TRY(check_picture(picture));
  const Canvas size{tile.width, tile.height};
  if (size.width == 0 || size.height == 0 || tile.x + size.width > picture.size.width ||
      tile.y + size.height > picture.size.height) {
    return fail(ErrorCode::kInternal, "A tile lies outside its image.");
  }
  const std::string pixels = cut(picture, tile);
  auto data = format == v1::WEBP  ? encode_webp(pixels, size, kWebpLevel)
              : format == v1::PNG ? encode_png(pixels, size, kPngLevel)
                                  : fail(ErrorCode::kUnsupported,
                                         "The server does not support this lossless format.");
  DIAPHANE_TRY(data);
  return CodedTile{format, std::move(*data), sha256(pixels)};
}

}  // namespace diaphane::render
