#include "scene/environment_import.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <numbers>
#include <vector>

namespace diaphane::scene {
namespace {

using Pixel = std::array<float, 3>;
using Pixels = std::vector<Pixel>;

std::string head(std::uint32_t width, std::uint32_t height) {
  return "#?RADIANCE\n# made by a test\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n\n-Y " +
         std::to_string(height) + " +X " + std::to_string(width) + "\n";
}

std::string flat(std::uint32_t width, std::uint32_t height, const Pixels& pixels) {
  std::string file = head(width, height);
  for (const Pixel& p : pixels) {
    const Rgbe coded = to_rgbe(p[0], p[1], p[2]);
    file.append(coded.begin(), coded.end());
  }
  return file;
}

double mean_of(const EnvironmentPicture& picture) {
  double sum = 0, weights = 0;
  for (std::uint32_t j = 0; j < picture.height; ++j) {
    const double weight = std::sin(std::numbers::pi * (j + 0.5) / picture.height);
    for (std::uint32_t i = 0; i < picture.width; ++i) {
      const Rgbe& p = picture.pixels[i + std::size_t{j} * picture.width];
      sum += weight * (0.2126 * static_cast<double>(radiance_of(p, 0)) +
                       0.7152 * static_cast<double>(radiance_of(p, 1)) +
                       0.0722 * static_cast<double>(radiance_of(p, 2)));
      weights += weight;
    }
  }
  return sum / weights;
}

PanoramaFault fault_of(const std::string& file) {
  const auto imported = import_panorama(file);
  EXPECT_FALSE(imported);
  return imported ? PanoramaFault::kTooLarge : imported.error();
}

TEST(ImportPanorama, ScalesConstantPictureToOne) {
  const auto imported = import_panorama(flat(8, 4, Pixels(32, {40, 40, 40})));
  ASSERT_TRUE(imported);
  for (const Rgbe& pixel : imported->pixels) EXPECT_FLOAT_EQ(radiance_of(pixel, 1), 1);
}

TEST(ImportPanorama, KeepsTheEnergyAndPlaceOfASingleSun) {
  constexpr std::uint32_t kWidth = 4096, kHeight = 2048;
  std::string file = head(kWidth, kHeight);
  // In runs, which is how 4096 x 2048 pixels fit into 4 MB. The sun is in the middle of row 700.
  const Rgbe sky = to_rgbe(1, 1, 1), sun = to_rgbe(1e5f, 1e5f, 1e5f);
  constexpr std::uint32_t kAcross = 1000, kDown = 700;
  for (std::uint32_t y = 0; y < kHeight; ++y) {
    file += {'\2', '\2', static_cast<char>(kWidth >> 8), static_cast<char>(kWidth & 255)};
    for (std::size_t c = 0; c < 4; ++c) {
      const auto run = [&](std::uint32_t count, const Rgbe& pixel) {
        for (; count > 0; count -= std::min(count, 127u)) {
          file += static_cast<char>(128 + std::min(count, 127u));
          file += static_cast<char>(pixel[c]);
        }
      };
      const std::uint32_t before = y == kDown ? kAcross : kWidth;
      run(before, sky);
      if (y == kDown) run(1, sun);
      if (y == kDown) run(kWidth - kAcross - 1, sky);
    }
  }
  const auto imported = import_panorama(file);
  ASSERT_TRUE(imported) << word_of(imported.error());
  EXPECT_EQ(imported->width, 1024u);
  EXPECT_EQ(imported->height, 512u);
  EXPECT_NEAR(mean_of(*imported), 1, 2e-3);
  const Rgbe& bright = imported->pixels[kAcross / 4 + std::size_t{kDown / 4} * 1024];
  const Rgbe& other = imported->pixels[5];
  const float expected = (1e5f + 15) / 16;  // of 16 pixels, one is the sun
  EXPECT_NEAR(radiance_of(bright, 0) / radiance_of(other, 0), expected, expected / 100);
}

TEST(ImportPanorama, ReadsOldRepetitions) {
  std::string file = head(8, 4);
  const auto pixel = [&](const Rgbe& p) { file.append(p.begin(), p.end()); };
  for (int y = 0; y < 4; ++y) {
    pixel(to_rgbe(2, 2, 2));
    pixel({1, 1, 1, 7});
  }
  const auto imported = import_panorama(file);
  ASSERT_TRUE(imported);
  EXPECT_FLOAT_EQ(radiance_of(imported->pixels[31], 2), 1);
}

TEST(ImportPanorama, RefusesBadFilesByReason) {
  const std::string good = flat(8, 4, Pixels(32, {1, 1, 1}));
  EXPECT_EQ(fault_of(std::string(kMostPanoramaBytes + 1, 'x')), PanoramaFault::kTooLarge);
  EXPECT_EQ(fault_of("\x89PNG\r\n\x1a\n"), PanoramaFault::kFormat);
  EXPECT_EQ(fault_of(good.substr(0, good.size() - 1)), PanoramaFault::kDamaged);
  EXPECT_EQ(fault_of(good.substr(0, 30)), PanoramaFault::kDamaged);
  EXPECT_EQ(fault_of(head(8192, 4096)), PanoramaFault::kTooManyPixels);
  EXPECT_EQ(fault_of(flat(4, 4, Pixels(16, {1, 1, 1}))), PanoramaFault::kShape);
  EXPECT_EQ(fault_of(flat(8, 4, Pixels(32, {0, 0, 0}))), PanoramaFault::kBlack);
  std::string xyz = good;
  xyz.replace(xyz.find("rgbe"), 4, "xyze");
  EXPECT_EQ(fault_of(xyz), PanoramaFault::kVariant);
  std::string mirrored = good;
  mirrored.replace(mirrored.find("-Y"), 2, "+Y");
  EXPECT_EQ(fault_of(mirrored), PanoramaFault::kVariant);
}

TEST(ImportPanorama, RunsNeverWriteBeyondTheirLine) {
  for (const std::string& runs :
       {std::string("\x89\x01"), std::string("\x09"), std::string("\0", 1)}) {
    EXPECT_EQ(fault_of(head(8, 4) + std::string("\2\2\0\10", 4) + runs), PanoramaFault::kDamaged);
  }
  EXPECT_EQ(fault_of(head(8, 4) + std::string("\2\2\1\0", 4)), PanoramaFault::kDamaged)
      << "the line names another width";
  EXPECT_EQ(fault_of(head(8, 4) + std::string("\1\1\1\7", 4)), PanoramaFault::kDamaged)
      << "there is no pixel to repeat";
}

#ifdef DIAPHANE_HAVE_EXR

void put(std::string& file, const void* data, std::size_t bytes) {
  file.append(static_cast<const char*>(data), bytes);
}
template <typename T>
void put(std::string& file, T value) {
  put(file, &value, sizeof value);
}
void attribute(std::string& file, const char* name, const char* type, const std::string& value) {
  put(file, name, std::strlen(name) + 1);
  put(file, type, std::strlen(type) + 1);
  put(file, static_cast<std::int32_t>(value.size()));
  file += value;
}

/// Writes 32-bit floats in lines without compression.
std::string exr(std::int32_t width, std::int32_t height, const Pixels& pixels) {
  std::string channels, window, centre, file("\x76\x2f\x31\x01\x02\0\0\0", 8);
  for (const char* name : {"B", "G", "R"}) {
    put(channels, name, 2);
    for (const std::int32_t part : {2, 0, 1, 1})
      put(channels, part);  // float, not linear, sampling
  }
  channels += '\0';
  for (const std::int32_t part : {0, 0, width - 1, height - 1}) put(window, part);
  put(centre, std::array<float, 2>{});
  const std::string one("\0\0\x80\x3f", 4);
  attribute(file, "channels", "chlist", channels);
  attribute(file, "compression", "compression", std::string(1, '\0'));
  attribute(file, "dataWindow", "box2i", window);
  attribute(file, "displayWindow", "box2i", window);
  attribute(file, "lineOrder", "lineOrder", std::string(1, '\0'));
  attribute(file, "pixelAspectRatio", "float", one);
  attribute(file, "screenWindowCenter", "v2f", centre);
  attribute(file, "screenWindowWidth", "float", one);
  file += '\0';
  const std::int32_t bytes = width * 12;
  const std::size_t first = file.size() + 8 * static_cast<std::size_t>(height);
  for (std::int32_t y = 0; y < height; ++y) {
    put(file,
        std::uint64_t{first + static_cast<std::size_t>(y) * static_cast<std::size_t>(bytes + 8)});
  }
  for (std::int32_t y = 0; y < height; ++y) {
    put(file, y);
    put(file, bytes);
    for (const std::size_t c : {2U, 1U, 0U}) {
      for (std::int32_t x = 0; x < width; ++x)
        put(file, pixels[static_cast<std::size_t>(x + y * width)][c]);
    }
  }
  return file;
}

TEST(ImportExr, LetsOnlyFiniteNumbersThatAreNotNegativeThrough) {
  Pixels pixels(16 * 8, {1, 1, 1});
  pixels[3] = {std::numeric_limits<float>::quiet_NaN(), -5, 1};
  pixels[40] = Pixel{std::numeric_limits<float>::infinity(), 65504, 1};
  pixels[41] = Pixel{1, 1, 65504};
  const auto imported = import_panorama(exr(16, 8, pixels));
  ASSERT_TRUE(imported) << word_of(imported.error());
  const Rgbe& repaired = imported->pixels[3];
  EXPECT_EQ(radiance_of(repaired, 0), 0);
  EXPECT_EQ(radiance_of(repaired, 1), 0);
  EXPECT_GT(radiance_of(repaired, 2), 0);
  const Rgbe& sun = imported->pixels[40];
  EXPECT_EQ(radiance_of(sun, 0), radiance_of(sun, 1)) << "infinity is the largest half number";
  EXPECT_NEAR(radiance_of(imported->pixels[41], 2), radiance_of(sun, 0), radiance_of(sun, 0) / 100);
  EXPECT_NEAR(mean_of(*imported), 1, 0.01);
  EXPECT_TRUE(read_environment(write_environment(*imported)));
}

TEST(ImportExr, CutsEnormousRadiances) {
  Pixels pixels(16 * 8, {1, 1, 1});
  pixels[1] = {3e38f, 3e38f, 3e38f};
  const auto imported = import_panorama(exr(16, 8, pixels));
  ASSERT_TRUE(imported);
  for (const Rgbe& pixel : imported->pixels) EXPECT_LE(radiance_of(pixel, 0), kBrightestPixel);
}

TEST(ImportExr, RefusesTruncatedAndCorruptedFiles) {
  const std::string file = exr(16, 8, Pixels(16 * 8, {1, 2, 3}));
  for (std::size_t end = 0; end < file.size(); end += 7) {
    EXPECT_FALSE(import_panorama(file.substr(0, end))) << end;
  }
}

#endif

}  // namespace
}  // namespace diaphane::scene
