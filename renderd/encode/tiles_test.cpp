#include "renderd/encode/tiles.h"

#include <gtest/gtest.h>
#include <png.h>
#include <sodium.h>
#include <webp/decode.h>

#include <random>

#include "tests/support/renderd/test_pictures.h"

namespace diaphane::render {
namespace {

std::string decode_png(const std::string& file) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_memory(&image, file.data(), file.size()));
  EXPECT_EQ(image.format, unsigned(PNG_FORMAT_RGB));
  std::string pixels(std::size_t{3} * image.width * image.height, 0);
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr));
  return pixels;
}

std::string decode_webp(const std::string& file) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(file.data());
  WebPBitstreamFeatures features;
  EXPECT_EQ(WebPGetFeatures(bytes, file.size(), &features), VP8_STATUS_OK);
  EXPECT_EQ(features.format, 2) << "lossless";
  EXPECT_FALSE(features.has_alpha);
  int width = 0, height = 0;
  std::uint8_t* rgb = WebPDecodeRGB(bytes, file.size(), &width, &height);
  std::string pixels(reinterpret_cast<const char*>(rgb), std::size_t{3} * width * height);
  WebPFree(rgb);
  return pixels;
}

PictureRgb8 noisy(Canvas size) {
  PictureRgb8 picture = smooth_picture(size.width, size.height);
  std::mt19937 random(9);
  for (std::uint8_t& value : picture.pixels) value ^= random() % 4;
  return picture;
}

TEST(Tiles, CoverEveryPixelOnceAndAreAtMost256Wide) {
  for (const Canvas size :
       {Canvas{16, 16}, Canvas{256, 256}, Canvas{257, 255}, Canvas{1280, 720}, Canvas{1281, 721}}) {
    std::vector<int> covered(std::size_t{size.width} * size.height);
    for (const Tile& tile : plan_tiles(size)) {
      ASSERT_GT(tile.width, 0U);
      ASSERT_LE(tile.width, kTileSide);
      ASSERT_LE(tile.height, kTileSide);
      for (std::uint32_t y = tile.y; y < tile.y + tile.height; ++y) {
        for (std::uint32_t x = tile.x; x < tile.x + tile.width; ++x) {
          ++covered.at(std::size_t{y} * size.width + x);
        }
      }
    }
    EXPECT_TRUE(std::all_of(covered.begin(), covered.end(), [](int n) { return n == 1; }));
  }
  EXPECT_EQ(plan_tiles({1280, 720}).size(), 15U);
}

TEST(Tiles, RoundTripEveryPixelAndHashThem) {
  const PictureRgb8 picture = noisy({300, 270});
  for (const v1::StillFormat format : {v1::PNG, v1::WEBP}) {
    PictureRgb8 back = plain_picture(picture.size, 0, 0, 0);
    for (const Tile& tile : plan_tiles(picture.size)) {
      const auto coded = encode_tile(picture, tile, format);
      ASSERT_TRUE(coded) << coded.error().message;
      EXPECT_EQ(coded->format, format);
      const std::string pixels =
          format == v1::PNG ? decode_png(coded->data) : decode_webp(coded->data);
      ASSERT_EQ(pixels.size(), std::size_t{3} * tile.width * tile.height);
      std::string hash(crypto_hash_sha256_BYTES, 0);
      crypto_hash_sha256(reinterpret_cast<unsigned char*>(hash.data()),
                         reinterpret_cast<const unsigned char*>(pixels.data()), pixels.size());
      EXPECT_EQ(coded->hash, hash);
      for (std::uint32_t y = 0; y < tile.height; ++y) {
        std::copy_n(
            pixels.begin() + std::size_t{3} * y * tile.width, std::size_t{3} * tile.width,
            back.pixels.begin() + std::size_t{3} * ((tile.y + y) * picture.size.width + tile.x));
      }
    }
    EXPECT_EQ(back.pixels, picture.pixels);
  }
}

TEST(Tiles, RefuseTileOutsideTheImage) {
  const PictureRgb8 picture = noisy({40, 30});
  for (const Tile& wrong :
       {Tile{0, 0, 41, 30}, Tile{1, 0, 40, 30}, Tile{0, 0, 0, 10}, Tile{0, 25, 10, 10}}) {
    EXPECT_FALSE(encode_tile(picture, wrong, v1::PNG).has_value());
  }
  EXPECT_FALSE(encode_tile(picture, {0, 0, 40, 30}, v1::STILL_FORMAT_UNSPECIFIED).has_value());
}

}  // namespace
}  // namespace diaphane::render
