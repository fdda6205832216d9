#include "renderd/composite/wire.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace diaphane::render {
namespace {

std::vector<PackedPixel> made(std::mt19937_64& random, std::size_t count) {
  std::vector<PackedPixel> pixels;
  while (pixels.size() < count) {
    PackedPixel p{};
    for (auto& m : p.mean) m = static_cast<std::uint16_t>(random());
    for (auto& h : p.half) h = static_cast<std::uint8_t>(random());
    p.state = static_cast<std::uint8_t>(random());
    pixels.insert(
        pixels.end(),
        std::min<std::size_t>(1 + random() % 9 * (random() % 2 * 40), count - pixels.size()), p);
  }
  return pixels;
}

TEST(PartsOnTheWire, RoundTrip) {
  std::mt19937_64 random(1);
  for (const std::size_t count : {0u, 1u, 2u, 3u, 100u, 5000u}) {
    const auto pixels = made(random, count);
    const auto bytes = pixels_to_wire(pixels.data(), count);
    EXPECT_LE(bytes.size(), 10 * count + 20);
    const auto back = pixels_from_wire(bytes, count);
    ASSERT_TRUE(back);
    EXPECT_EQ(*back, pixels);
  }
  const std::vector<PackedPixel> black(1'000'000);
  EXPECT_LT(pixels_to_wire(black.data(), black.size()).size(), 20u);
}

/// Arbitrary bytes give an error or pixels, but never more pixels than requested.
TEST(PartsOnTheWire, GuidesMakeARoundTripOrAreRefused) {
  const std::vector<PackedGuides> guides{{{1, 2, 0xffff}}, {{0x1234, 0, 7}}};
  const std::string bytes = guides_to_wire(guides);
  const auto back = guides_from_wire(bytes, 2);
  ASSERT_TRUE(back);
  ASSERT_EQ(back->size(), 2u);
  EXPECT_EQ(std::memcmp(back->data(), guides.data(), sizeof(PackedGuides) * 2), 0);
  EXPECT_TRUE(guides_from_wire("", 2)->empty()) << "an older worker sends none";
  EXPECT_FALSE(guides_from_wire(bytes, 3));
  EXPECT_FALSE(guides_from_wire(bytes.substr(1), 2));
}

TEST(PartsOnTheWire, RefuseMalformedBytes) {
  std::mt19937_64 random(2);
  const auto pixels = made(random, 200);
  const std::string whole = pixels_to_wire(pixels.data(), pixels.size());
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_FALSE(pixels_from_wire(whole.substr(0, length), 200)) << length;
  }
  EXPECT_FALSE(pixels_from_wire(whole, 199));
  EXPECT_FALSE(pixels_from_wire(whole, 201));
  EXPECT_FALSE(pixels_from_wire(std::string(40, '\xff'), 200));
  for (int round = 0; round < 20'000; ++round) {
    std::string spoilt = whole;
    spoilt[random() % spoilt.size()] = static_cast<char>(random());
    if (const auto got = pixels_from_wire(spoilt, 200)) {
      ASSERT_EQ(got->size(), 200u);
    }
  }
}

TEST(PartsOnTheWire, BandsJoinToTheWholePart) {
  std::mt19937_64 random(3);
  FilmPart part{
      .width = 30, .first_row = 32, .rows = 77, .samples = 4, .pixels = made(random, 30 * 77)};
  const auto all = part.pixels;
  for (const std::size_t bytes : {1u, 10'000u, 1'000'000u}) {
    std::vector<PackedPixel> joined;
    std::uint32_t next = 32;
    for (const FilmPart& band : in_bands(part, bytes)) {
      EXPECT_EQ(band.first_row, next);
      EXPECT_EQ(band.samples, 4u);
      EXPECT_TRUE(fits(band, {30, 109}));
      next += band.rows;
      joined.insert(joined.end(), band.pixels.begin(), band.pixels.end());
    }
    EXPECT_EQ(next, 109u);
    EXPECT_EQ(joined, all);
  }
}

}  // namespace
}  // namespace diaphane::render
