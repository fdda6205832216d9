#include "renderd/scene/texture.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/renderd/test_textures.h"

#if defined(DIAPHANE_HAVE_JPEG)
#include <turbojpeg.h>
#endif

namespace diaphane::render {
namespace {

TEST(Texture, RefusesFilesThatAreNotImages) {
  const std::string files[] = {"",
                               "P6 2 2 255 abcdefghijkl",
                               std::string(1000, '\0'),
                               "\xff\xd8\xff",
                               "\x89PNG\r\n\x1a\n",
                               "GIF89a",
                               std::string("\x89PNG\r\n\x1a\n") + std::string(500, 'x')};
  for (const std::string& file : files) {
    EXPECT_FALSE(texture_size(file)) << file.substr(0, 8);
    EXPECT_FALSE(decode_texture(file)) << file.substr(0, 8);
  }
}

TEST(Texture, RefusesFileThatIsTooLarge) {
  const auto size = texture_size(std::string(kMostTextureBytes + 1, '\0'));
  ASSERT_FALSE(size);
  EXPECT_NE(size.error().message.find("8 MiB"), std::string::npos);
}

TEST(Texture, LinearizesWithTheSrgbCurve) {
  EXPECT_EQ(linear_of_srgb()[0], 0.0f);
  EXPECT_EQ(linear_of_srgb()[255], 1.0f);
  EXPECT_NEAR(linear_of_srgb()[10], 10 / 255.0 / 12.92, 1e-8);
  EXPECT_NEAR(linear_of_srgb()[128], 0.2158605, 1e-6);
}

#if defined(DIAPHANE_HAVE_PNG)

std::string picture() {
  return test::png(7, 3, [](std::uint32_t i, std::uint32_t j) {
    return test::Rgb8{static_cast<std::uint8_t>(30 * i), static_cast<std::uint8_t>(100 * j), 9};
  });
}

TEST(PngTexture, RoundTrips) {
  const auto decoded = decode_texture(picture());
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_EQ(decoded->size.width, 7u);
  EXPECT_EQ(decoded->size.height, 3u);
  ASSERT_EQ(decoded->rgb.size(), 63u);
  for (std::uint32_t j = 0; j < 3; ++j) {
    for (std::uint32_t i = 0; i < 7; ++i) {
      EXPECT_EQ(decoded->rgb[3 * (i + 7 * j)], 30 * i);
      EXPECT_EQ(decoded->rgb[3 * (i + 7 * j) + 1], 100 * j);
    }
  }
}

/// The header is checked before memory of the size that it declares is allocated.
TEST(PngTexture, RefusesTooManyPixelsByTheHeader) {
  for (const auto& [width, height] : {std::pair{4097u, 1u}, std::pair{1u, 4097u}}) {
    const auto size = texture_size(test::png(width, height, [](auto, auto) {
      return test::Rgb8{1, 2, 3};
    }));
    ASSERT_FALSE(size);
    EXPECT_NE(size.error().message.find("4096"), std::string::npos);
  }
}

TEST(PngTexture, DamagedFileIsAnErrorOrAnImageOfItsSize) {
  const std::string whole = picture();
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    const auto decoded = decode_texture(whole.substr(0, cut));
    if (decoded) {
      EXPECT_EQ(decoded->rgb.size(), 63u);
    }
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string broken = whole;
    broken[at] = static_cast<char>(broken[at] ^ 0x55);
    const auto decoded = decode_texture(broken);
    if (decoded) {
      EXPECT_EQ(decoded->rgb.size(), 3u * decoded->size.width * decoded->size.height);
    }
  }
}

#endif

#if defined(DIAPHANE_HAVE_JPEG)

/// A picture of a single colour, which the encoding hardly changes.
std::string jpeg(int width, int height) {
  std::vector<unsigned char> rgb;
  for (int i = 0; i < width * height; ++i) rgb.insert(rgb.end(), {200, 100, 50});
  const tjhandle handle = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;
  tjCompress2(handle, rgb.data(), width, 0, height, TJPF_RGB, &data, &size, TJSAMP_444, 95, 0);
  std::string file(reinterpret_cast<char*>(data), size);
  tjFree(data);
  tjDestroy(handle);
  return file;
}

TEST(JpegTexture, RoundTripsApproximately) {
  const auto decoded = decode_texture(jpeg(40, 30));
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_EQ(decoded->size.width, 40u);
  EXPECT_EQ(decoded->size.height, 30u);
  for (std::size_t i = 0; i < 1200; ++i) {
    ASSERT_NEAR(decoded->rgb[3 * i], 200, 3);
    ASSERT_NEAR(decoded->rgb[3 * i + 1], 100, 3);
    ASSERT_NEAR(decoded->rgb[3 * i + 2], 50, 3);
  }
}

TEST(JpegTexture, RefusesTruncatedAndTooWideFiles) {
  const std::string whole = jpeg(200, 200);
  const auto half = decode_texture(whole.substr(0, whole.size() / 2));
  ASSERT_FALSE(half);
  EXPECT_NE(half.error().message.find("corrupted"), std::string::npos);
  EXPECT_FALSE(texture_size(jpeg(4100, 1)));
}

#endif

}  // namespace
}  // namespace diaphane::render
