#include "renderd/film/part.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace diaphane::render {
namespace {

TEST(FilmPart, PackedMeanRoundsToElevenBits) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> exponent(-39.0f, 22.9f);
  for (int i = 0; i < 100'000; ++i) {
    const float x = std::exp2(exponent(random));
    ASSERT_NEAR(unpack_mean(pack_mean(x)), x, std::ldexp(x, -11)) << x;
  }
  EXPECT_EQ(unpack_mean(pack_mean(0.0f)), 0.0f);
  EXPECT_EQ(unpack_mean(pack_mean(1.0f)), 1.0f);
  EXPECT_GT(unpack_mean(pack_mean(1e30f)), 1e7f) << "values beyond the range are clamped";
}

/// Verifies the display error that the comment of PackedPixel states.
TEST(FilmPart, PackingErrorIsBelowASixteenthOfADisplayLevel) {
  double squared = 0;
  int count = 0;
  for (float x = 1e-6f; x < 1.0f; x *= 1.0007f, ++count) {
    const double off = std::pow(unpack_mean(pack_mean(x)), 1 / 2.2) - std::pow(x, 1 / 2.2);
    ASSERT_LT(std::abs(off), 2.3e-4) << x;
    squared += off * off;
  }
  EXPECT_LT(std::sqrt(squared / count), 1.3e-4);
}

TEST(FilmPart, PackedHalfKeepsSignMagnitudeAndMeanSquare) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal(0, 0.05);
  double squared = 0, packed = 0;
  for (int i = 0; i < 200'000; ++i) {
    const auto x = static_cast<float>(std::clamp(normal(random), -1.0, 1.0));
    const float y = unpack_half(pack_half(x));
    ASSERT_NEAR(y, x, 0.126f * std::abs(x) + 1e-9f);
    squared += double(x) * x;
    packed += double(y) * y;
  }
  EXPECT_NEAR(std::sqrt(packed / squared), 1, 0.003);
  EXPECT_EQ(unpack_half(pack_half(1.0f)), 1.0f);
  EXPECT_EQ(unpack_half(pack_half(-1.0f)), -1.0f);
  EXPECT_EQ(unpack_half(pack_half(0.0f)), 0.0f);
}

struct OnePixel {
  double sum[3] = {};
  float difference[3] = {};
  std::uint32_t state = 0;
  FilmView film() { return {sum, difference, &state}; }
  ConstFilmView view() const { return {sum, difference, &state}; }
};

/// Samples, some of which are not finite, are added to two films that are packed and merged. Mean,
/// noise, marks and counts of dropped samples are those of one film with all of them.
TEST(FilmPart, MergedPixelsEqualThePixelOfAllSamples) {
  std::mt19937_64 random(3);
  std::exponential_distribution<float> light(1.0f);
  for (int round = 0; round < 2'000; ++round) {
    OnePixel all, merged;
    for (int device = 0; device < 2; ++device) {
      OnePixel one;
      const std::uint64_t samples = 2 + 2 * (random() % 6);
      for (std::uint64_t s = 0; s < samples; ++s) {
        const float x = random() % 9 == 0 ? NAN : light(random);
        PixelBatch batch;
        batch.add({x, 2 * x, 0.0f}, random() % 2 == 0, s, random() % 7 == 0);
        fold(one.film(), 0, batch);
        fold(all.film(), 0, batch);
      }
      merge_pixel(merged.film(), 0, pack_pixel(one.view(), 0, samples), samples);
      const PixelEstimate was = estimate_of(one.view(), 0, samples);
      OnePixel alone;
      merge_pixel(alone.film(), 0, pack_pixel(one.view(), 0, samples), samples);
      const PixelEstimate is = estimate_of(alone.view(), 0, samples);
      ASSERT_NEAR(is.mean.y, was.mean.y, 0x1p-11f * was.mean.y + 1e-12f);
      ASSERT_NEAR(is.deviation.y, was.deviation.y,
                  0.13f * std::abs(was.deviation.y) + 0x1p-10f * was.mean.y);
    }
    ASSERT_EQ(merged.state, all.state);
    for (int c = 0; c < 3; ++c) {
      ASSERT_NEAR(merged.sum[c], all.sum[c], 0x1p-11 * all.sum[c] + 1e-9);
    }
  }
}

}  // namespace
}  // namespace diaphane::render
