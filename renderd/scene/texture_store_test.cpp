#include "renderd/scene/texture_store.h"

#include <gtest/gtest.h>

#include "tests/support/renderd/test_textures.h"

namespace diaphane::render {
namespace {

constexpr std::uint32_t kSide = 256;
constexpr std::size_t kBytes = std::size_t{kSide} * kSide * 16;  // without rows and file

/// Returns a different file for each number.
std::string picture(unsigned number, std::uint32_t side = kSide) {
  return test::png(side, side, [number](std::uint32_t, std::uint32_t) {
    return test::Rgb8{static_cast<std::uint8_t>(number), 1, 2};
  });
}

struct TextureStore : testing::Test {
  TextureStore() { limit_texture_memory(4 * kBytes, 2 * kBytes + kBytes / 2); }
  ~TextureStore() override { limit_texture_memory(kTextureMemory, kOwnersTextureMemory); }
  void SetUp() override {
    if (picture(0).empty()) GTEST_SKIP() << "built without PNG";
  }
  static auto prepare(const std::string& file, const std::string& owner = "") {
    return prepare_textures_for(owner, {{&file, "lights[3].sphere.texture"}}, nullptr);
  }
};

TEST_F(TextureStore, BoundsTexturesOfAllScenesAndNamesTheExceedingField) {
  std::vector<std::shared_ptr<const PreparedTextures>> held;
  for (unsigned i = 0; i < 3; ++i) {
    const auto prepared = prepare(picture(i));
    ASSERT_TRUE(prepared) << prepared.error().message;
    held.push_back(*prepared);
  }
  EXPECT_GE(texture_memory(), 3 * kBytes);
  const auto refused = prepare(picture(9));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooMany);
  EXPECT_EQ(refused.error().field, "lights[3].sphere.texture");
  (void)take_freed_texture_memory();
  held.pop_back();
  EXPECT_GE(take_freed_texture_memory(), kBytes);
  EXPECT_TRUE(prepare(picture(9)));
  held.clear();
  EXPECT_EQ(texture_memory(), 0U);
}

TEST_F(TextureStore, LimitsTheTexturesOfOneOwner) {
  const auto first = prepare(picture(1), "ann"), second = prepare(picture(2), "ann");
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(prepare(picture(3), "ann"));
  EXPECT_TRUE(prepare(picture(3), "bob"));
}

TEST_F(TextureStore, DecodesEqualFilesOnce) {
  const auto one = prepare(picture(1), "ann");
  const auto other = prepare(picture(1), "bob");
  ASSERT_TRUE(one && other);
  EXPECT_EQ(one->get(), other->get());
  EXPECT_LT(texture_memory(), 2 * kBytes);
}

TEST_F(TextureStore, UnreadableFileUsesNoMemory) {
  std::string file = picture(1);
  file.resize(file.size() / 2);
  EXPECT_FALSE(prepare(file));
  EXPECT_EQ(texture_memory(), 0U);
}

TEST_F(TextureStore, ReducesLargePicturesToTheirMeansInLinearLight) {
  limit_texture_memory(kTextureMemory, kOwnersTextureMemory);
  // Black and white pixels alternate, so each texel of 2 x 2 pixels is half as bright as white.
  constexpr std::uint32_t kWide = 2050, kHigh = 2047;
  const std::string file = test::png(kWide, kHigh, [](std::uint32_t x, std::uint32_t y) {
    const auto c = static_cast<std::uint8_t>((x + y) % 2 == 0 ? 255 : 0);
    return test::Rgb8{c, c, c};
  });
  EXPECT_EQ(kept_size({kWide, kHigh}), (TextureSize{1025, 1024}));
  EXPECT_EQ(kept_size({2048, 1024}), (TextureSize{2048, 1024}));
  const auto prepared = prepare(file);
  ASSERT_TRUE(prepared) << prepared.error().message;
  const PreparedTextures& textures = **prepared;
  EXPECT_EQ(textures.textures[0].width, 1025);
  ASSERT_EQ(textures.texels.size(), std::size_t{1025} * 1024);
  EXPECT_NEAR(textures.means[0].x, 0.5, 1e-3) << "one row of texels covers one row of pixels";
  EXPECT_FLOAT_EQ(textures.texels[1025 * 100 + 7].x, 0.5f);
  EXPECT_LT(texture_memory(), 40U << 20);
}

TEST_F(TextureStore, LimitsTheTexturePixelsOfVisitors) {
  const std::string allowed = picture(1, 1024), large = picture(1, 1025);
  EXPECT_TRUE(check_visitors_textures({{&allowed, "a"}}));
  const auto refused = check_visitors_textures({{&large, "lights[0].environment.texture"}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "lights[0].environment.texture");
  EXPECT_TRUE(bytes_of_textures({{&large, "a"}})) << "an account holder's may be larger";
}

}  // namespace
}  // namespace diaphane::render
