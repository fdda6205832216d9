#include "renderd/encode/png_rows.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cstring>

#include "tests/support/renderd/test_pictures.h"

namespace diaphane::render {
namespace {

PictureRgb8 read(const std::string& file) {
  PictureRgb8 picture;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_memory(&image, file.data(), file.size()));
  EXPECT_EQ(image.format, static_cast<png_uint_32>(PNG_FORMAT_RGB));
  picture.size = {image.width, image.height};
  picture.pixels.resize(PNG_IMAGE_SIZE(image));
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, picture.pixels.data(), 0, nullptr));
  return picture;
}

TEST(PngRows, FileDoesNotDependOnTheBandHeight) {
  const PictureRgb8 whole = smooth_picture(300, 97);
  std::string first;
  for (const std::uint32_t rows : {97u, 1u, 16u, 40u}) {
    auto png = make_png_rows(whole.size, 1);
    ASSERT_TRUE(png);
    std::string file;
    for (std::uint32_t y = 0; y < 97; y += rows) {
      const std::size_t row = 900, count = std::min(rows, 97 - y);
      const auto bytes = (*png)->add({whole.pixels.data() + row * y, row * count});
      ASSERT_TRUE(bytes);
      file += *bytes;
    }
    const auto rest = (*png)->finish();
    ASSERT_TRUE(rest);
    file += *rest;
    if (first.empty()) first = file;
    EXPECT_EQ(file, first);
    EXPECT_EQ(read(file).pixels, whole.pixels);
    for (const char* chunk : {"tEXt", "iTXt", "zTXt", "tIME", "eXIf", "iCCP"}) {
      EXPECT_EQ(file.find(chunk), std::string::npos);
    }
  }
}

TEST(PngRows, RefusesIncompleteSurplusOrMissingRows) {
  auto png = make_png_rows({10, 4}, 1);
  ASSERT_TRUE(png);
  const std::vector<std::uint8_t> pixels(30 * 5);
  EXPECT_FALSE((*png)->add({pixels.data(), 29}));
  EXPECT_FALSE((*png)->add({pixels.data(), 150})) << "a row too many";
  ASSERT_TRUE((*png)->add({pixels.data(), 90}));
  EXPECT_FALSE((*png)->finish()) << "a row too few";
}

}  // namespace
}  // namespace diaphane::render
