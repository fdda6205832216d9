#include "renderd/encode/frame_mark.h"

#include <gtest/gtest.h>

#include "tests/support/renderd/test_pictures.h"

namespace diaphane::render {
namespace {

constexpr std::uint64_t kNumbers[] = {0, 1, 0x800000, 0xabcdef, 0xffffff, 0x5000123};

TEST(FrameMark, RoundTripsThroughImagesOfAnySize) {
  for (const Canvas size : {Canvas{40, 16}, Canvas{97, 33}, Canvas{512, 512}, Canvas{1281, 719}}) {
    for (const std::uint64_t number : kNumbers) {
      PictureRgb8 picture = smooth_picture(size.width, size.height);
      EXPECT_EQ(read_frame_mark(picture), std::nullopt);
      draw_frame_mark(picture, number);
      EXPECT_EQ(read_frame_mark(picture), number & 0xffffff);
    }
  }
}

TEST(FrameMark, DrawsSquareCellsAtTheExpectedPositions) {
  PictureRgb8 picture = smooth_picture(80, 60);
  const PictureRgb8 before = picture;
  draw_frame_mark(picture, 0x800001);
  const auto white = [&](std::size_t x, std::size_t y) { return picture.pixels[3 * (80 * y + x)]; };
  for (const std::size_t y : {0, 1}) {
    EXPECT_EQ(white(0, y), 255);   // sync
    EXPECT_EQ(white(3, y), 0);     // sync
    EXPECT_EQ(white(4, y), 255);   // the highest bit
    EXPECT_EQ(white(51, y), 255);  // the lowest
    EXPECT_EQ(white(52, y), 255);  // checksum 0x80 ^ 0x01
    EXPECT_EQ(white(67, y), 255);
    for (std::size_t x = 68; x < 80; ++x) EXPECT_EQ(white(x, y), 0);
  }
  EXPECT_TRUE(std::equal(picture.pixels.begin() + 3 * 80 * 2, picture.pixels.end(),
                         before.pixels.begin() + 3 * 80 * 2))
      << "only the cells are drawn";
}

TEST(FrameMark, LeavesSmallImageUnchanged) {
  PictureRgb8 picture = smooth_picture(39, 30);
  const PictureRgb8 before = picture;
  draw_frame_mark(picture, 7);
  EXPECT_EQ(picture.pixels, before.pixels);
  EXPECT_EQ(read_frame_mark(picture), std::nullopt);
}

TEST(FrameMark, DetectsAWrongCell) {
  PictureRgb8 picture = smooth_picture(400, 300);
  draw_frame_mark(picture, 0x123456);
  for (std::size_t cell = 0; cell < 40; ++cell) {
    PictureRgb8 wrong = picture;
    for (std::size_t y = 0; y < 10; ++y) {
      for (std::size_t i = 0; i < 30; ++i) {
        std::uint8_t& value = wrong.pixels[3 * (400 * y + 10 * cell) + i];
        value = static_cast<std::uint8_t>(255 - value);
      }
    }
    EXPECT_EQ(read_frame_mark(wrong), std::nullopt) << cell;
  }
}

}  // namespace
}  // namespace diaphane::render
