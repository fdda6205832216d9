#include "renderd/cli/picture_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>

#ifdef DIAPHANE_HAVE_PNG
#include <png.h>
#endif
#ifdef DIAPHANE_HAVE_EXR
#include <tinyexr.h>
#endif

namespace diaphane::render::cli {
namespace {

PictureRgb8 gradient(Canvas size) {
  PictureRgb8 picture{size, std::vector<std::uint8_t>(std::size_t{3} * size.width * size.height)};
  std::iota(picture.pixels.begin(), picture.pixels.end(), std::uint8_t{0});
  return picture;
}

TEST(PictureFile, FormatFollowsTheFileExtension) {
  EXPECT_EQ(picture_format("a/b.png"), PictureFormat::kPng);
  EXPECT_EQ(picture_format("a.EXR"), PictureFormat::kExr);
  EXPECT_EQ(picture_format("a.ppm"), PictureFormat::kPpm);
  EXPECT_FALSE(picture_format(".png"));
  EXPECT_FALSE(picture_format("png"));
  EXPECT_TRUE(unwritable_picture("a.jpg"));
  EXPECT_FALSE(unwritable_picture("a.ppm"));
}

TEST(PictureFile, PpmStoresThePixelsUnchanged) {
  const PictureRgb8 picture = gradient({5, 3});
  const std::string bytes = encode_ppm(picture);
  const std::string head = "P6\n5 3\n255\n";
  ASSERT_EQ(bytes.size(), head.size() + 45);
  EXPECT_EQ(bytes.substr(0, head.size()), head);
  EXPECT_TRUE(std::equal(picture.pixels.begin(), picture.pixels.end(),
                         reinterpret_cast<const std::uint8_t*>(bytes.data()) + head.size()));
}

TEST(PictureFile, PngRoundTripsExactly) {
#ifdef DIAPHANE_HAVE_PNG
  const PictureRgb8 picture = gradient({37, 11});
  const auto bytes = encode_png(picture);
  ASSERT_TRUE(bytes) << bytes.error().message;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_memory(&image, bytes->data(), bytes->size()));
  EXPECT_EQ(image.width, 37u);
  EXPECT_EQ(image.height, 11u);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(image));
  ASSERT_TRUE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr));
  EXPECT_EQ(pixels, picture.pixels);
#else
  EXPECT_EQ(encode_png({}).error().code, ErrorCode::kUnsupported);
#endif
}

TEST(PictureFile, ExrRoundTripsExactlyInLinearColour) {
#ifdef DIAPHANE_HAVE_EXR
  PictureRgbF picture{{19, 33}, std::vector<float>(std::size_t{3} * 19 * 33)};
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    picture.pixels[i] = 1e-6f * static_cast<float>(i * i * i);
  }
  const auto bytes = encode_exr(picture);
  ASSERT_TRUE(bytes) << bytes.error().message;
  float* rgba = nullptr;
  int width = 0, height = 0;
  const char* why = nullptr;
  ASSERT_EQ(
      LoadEXRFromMemory(&rgba, &width, &height,
                        reinterpret_cast<const unsigned char*>(bytes->data()), bytes->size(), &why),
      TINYEXR_SUCCESS)
      << (why ? why : "");
  EXPECT_EQ(width, 19);
  EXPECT_EQ(height, 33);
  for (std::size_t pixel = 0; pixel < std::size_t{19} * 33; ++pixel) {
    for (std::size_t c = 0; c < 3; ++c) {
      ASSERT_EQ(rgba[4 * pixel + c], picture.pixels[3 * pixel + c]);
    }
  }
  std::free(rgba);
#else
  EXPECT_EQ(encode_exr({}).error().code, ErrorCode::kUnsupported);
#endif
}

TEST(PictureFile, FailedWriteKeepsTheOldFile) {
  const auto folder =
      std::filesystem::temp_directory_path() /
      ("picture_file_test-" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) +
       std::to_string(reinterpret_cast<std::uintptr_t>(this)));
  std::filesystem::create_directories(folder);
  const std::string path = (folder / "a.ppm").string();
  ASSERT_TRUE(write_file(path, "old"));
  ASSERT_TRUE(write_file(path, "new"));
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  EXPECT_EQ(text.str(), "new");
  // A directory in the way: the rename fails, and nothing temporary is left behind.
  std::filesystem::create_directories(folder / "b.ppm" / "inside");
  const auto refused = write_file((folder / "b.ppm").string(), "x");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kForbidden);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder),
                          std::filesystem::directory_iterator{}),
            2);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace diaphane::render::cli
