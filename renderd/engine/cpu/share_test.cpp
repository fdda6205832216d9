// Several devices render one picture: shares are disjoint, and samples that are taken from one film
// and merged into another give the same picture. This file tests the part of the engines.

#include <gtest/gtest.h>

#include <cmath>

#include "renderd/engine/cpu/engine.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render {
namespace {

constexpr Canvas kCanvas{61, 45};  // bands of 16, 16 and 13 rows

class Shares : public ::testing::Test {
 protected:
  std::unique_ptr<FrameRenderer> renderer(const Share& share = {}, Method method = {}) {
    auto made = *engine_->renderer(volume_, 7, 0, method);
    EXPECT_TRUE(made->set_scene(test::skull_scene(), kCanvas));
    EXPECT_TRUE(made->set_share(share));
    return made;
  }
  static std::vector<float> radiance(FrameRenderer& renderer) {
    PictureRgbF picture;
    EXPECT_TRUE(renderer.radiance(picture));
    return picture.pixels;
  }
  /// Allows for the rounding of packed means, 2^-11, and of sums.
  static void expect_the_same(const std::vector<float>& a, const std::vector<float>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_NEAR(a[i], b[i], 0x1p-11f * b[i] + 1e-7f) << i;
    }
  }
  std::unique_ptr<Engine> engine_ = make_cpu_engine(2);
  std::shared_ptr<const DeviceVolume> volume_ = *engine_->load(test::skull_volume());
};

TEST_F(Shares, PartsOfOneSequenceReproduceTheSingleDeviceImage) {
  for (const std::uint32_t devices : {2u, 3u, 5u}) {
    const auto alone = renderer();
    ASSERT_TRUE(alone->render(4 * devices, nullptr));
    const auto merged = renderer({.part = 0, .parts = devices});
    ASSERT_TRUE(merged->render(4, nullptr));
    for (std::uint32_t d = 1; d < devices; ++d) {
      const auto other = renderer({.part = d, .parts = devices});
      ASSERT_TRUE(other->render(4, nullptr));
      FilmPart part;
      ASSERT_TRUE(*other->take_film(part));
      EXPECT_EQ(part.samples, 4u);
      ASSERT_TRUE(merged->merge_film(part));
    }
    EXPECT_EQ(merged->progress().samples, 4 * devices);
    expect_the_same(radiance(*merged), radiance(*alone));
    EXPECT_NEAR(merged->progress().error, alone->progress().error, 0.01 * alone->progress().error);
  }
}

TEST_F(Shares, BandsOfRowsReproduceTheSingleDeviceImage) {
  const auto alone = renderer();
  ASSERT_TRUE(alone->render(6, nullptr));
  const auto merged = renderer({.first_row = 16, .last_row = 32});
  ASSERT_TRUE(merged->render(6, nullptr));
  EXPECT_EQ(merged->progress().samples, 0u) << "of the pixels that have the fewest";
  for (const auto& [first, last] : {std::pair{0u, 16u}, std::pair{32u, 45u}}) {
    const auto other = renderer({.first_row = first, .last_row = last});
    ASSERT_TRUE(other->render(6, nullptr));
    FilmPart part;
    ASSERT_TRUE(*other->take_film(part));
    EXPECT_EQ(part.rows, last - first);
    ASSERT_TRUE(merged->merge_film(part));
  }
  EXPECT_EQ(merged->progress().samples, 6u);
  expect_the_same(radiance(*merged), radiance(*alone));
  EXPECT_NEAR(merged->progress().error, alone->progress().error, 0.01 * alone->progress().error);
  PictureRgb8 a, b;
  ASSERT_TRUE(merged->display(a) && alone->display(b));
  for (std::size_t i = 0; i < a.pixels.size(); ++i) ASSERT_NEAR(a.pixels[i], b.pixels[i], 1);
}

TEST_F(Shares, TakingFilmInPiecesEqualsTakingItAtOnce) {
  const auto from = renderer();
  const auto to = renderer({.sequence = 3});
  FilmPart part;
  EXPECT_FALSE(*from->take_film(part)) << "there is nothing";
  for (const std::uint32_t samples : {2u, 1u, 5u}) {
    ASSERT_TRUE(from->render(samples, nullptr));
    const auto taken = from->take_film(part);
    ASSERT_EQ(*taken, samples != 1) << "half a pair is left";
    if (*taken) {
      ASSERT_TRUE(to->merge_film(part));
    }
  }
  EXPECT_EQ(to->progress().samples, 8u);
  const auto alone = renderer();
  ASSERT_TRUE(alone->render(8, nullptr));
  expect_the_same(radiance(*to), radiance(*alone));
}

TEST_F(Shares, ChangingTheShareKeepsTheFilm) {
  const auto one = renderer({.sequence = 1});
  ASSERT_TRUE(one->render(3, nullptr));
  const auto refused = one->set_share({.sequence = 2});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kConflict);
  ASSERT_TRUE(one->render(1, nullptr));
  ASSERT_TRUE(one->set_share({.first_row = 0, .last_row = 16, .sequence = 2}));
  ASSERT_TRUE(one->render(4, nullptr));
  EXPECT_EQ(one->progress().samples, 4u);

  const auto first = renderer({.sequence = 1}), second = renderer({.sequence = 2});
  ASSERT_TRUE(first->render(4, nullptr) && second->render(4, nullptr));
  const auto a = radiance(*first), b = radiance(*second), got = radiance(*one);
  const std::size_t band = std::size_t{3} * 16 * kCanvas.width;
  for (std::size_t i = 0; i < got.size(); ++i) {
    ASSERT_NEAR(got[i], i < band ? (a[i] + b[i]) / 2 : a[i], 1e-5f * got[i] + 1e-7f) << i;
  }
}

TEST_F(Shares, RefusesMismatchedPartsAndKeepsTheImage) {
  const auto one = renderer();
  ASSERT_TRUE(one->render(2, nullptr));
  const auto before = radiance(*one);
  FilmPart part;
  part.width = kCanvas.width;
  part.rows = kCanvas.height;
  part.samples = 2;
  part.pixels.resize(std::size_t{part.width} * part.rows);
  for (const auto& spoil : std::vector<std::function<void(FilmPart&)>>{
           [](FilmPart& p) { p.width = 60; }, [](FilmPart& p) { p.rows = 44; },
           [](FilmPart& p) { p.first_row = 8; }, [](FilmPart& p) { p.first_row = 0xfffffff0u; },
           [](FilmPart& p) { p.samples = 3; }, [](FilmPart& p) { p.pixels.pop_back(); }}) {
    FilmPart bad = part;
    spoil(bad);
    EXPECT_FALSE(one->merge_film(bad));
  }
  EXPECT_FALSE(one->set_share({.first_row = 8}));
  EXPECT_FALSE(one->set_share({.first_row = 48}));
  EXPECT_FALSE(one->set_share({.first_row = 0, .last_row = 20}));
  EXPECT_EQ(radiance(*one), before);
  EXPECT_TRUE(one->merge_film(part));
}

}  // namespace
}  // namespace diaphane::render
