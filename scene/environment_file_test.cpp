#include "scene/environment_file.h"

#include <gtest/gtest.h>

namespace diaphane::scene {
namespace {

EnvironmentPicture two_by_one() { return {2, 1, {to_rgbe(1, 0.5f, 0.25f), to_rgbe(0, 0, 0)}}; }

TEST(EnvironmentFile, RoundTrips) {
  const std::string file = write_environment(two_by_one());
  const auto read = read_environment(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->width, 2u);
  EXPECT_EQ(read->height, 1u);
  EXPECT_EQ(read->pixels, two_by_one().pixels);
  EXPECT_TRUE(is_radiance(file)) << "other programs can open it";
}

TEST(EnvironmentFile, RoundsToTheNearestSharedExponent) {
  for (const float value :
       {1e-6f, 0.02f, 0.5f, 0.9999f, 1.0f, 1.999f, 3.7f, 1e5f, kBrightestPixel}) {
    const Rgbe pixel = to_rgbe(value, value / 3, 0);
    EXPECT_NEAR(radiance_of(pixel, 0), value, value / 256) << value;
    EXPECT_NEAR(radiance_of(pixel, 1), value / 3, value / 256) << value;
    EXPECT_EQ(radiance_of(pixel, 2), 0);
  }
  EXPECT_EQ(to_rgbe(0, 0, 0), Rgbe{});
}

TEST(EnvironmentFile, RefusesAnythingElse) {
  const std::string file = write_environment(two_by_one());
  std::string bright = file;
  bright.back() = '\xff';  // the exponent of the last pixel
  std::string wide = file;
  wide.replace(wide.find("+X 2"), 4, "+X 9");
  for (const std::string& wrong : {std::string(), file.substr(0, file.size() - 1), file + "x",
                                   bright, wide, std::string("#?RADIANCE\n\n-Y 1 +X 1\nabcd")}) {
    EXPECT_FALSE(read_environment(wrong));
  }
  EXPECT_TRUE(environment_size(file));
  EXPECT_FALSE(environment_size(wide));
}

}  // namespace
}  // namespace diaphane::scene
