// A band of a picture's rows equals that part of the picture bit for bit, whatever the band.

#include <gtest/gtest.h>

#include "renderd/engine/cpu/engine.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render {
namespace {

constexpr std::uint32_t kWidth = 61, kHeight = 83;

class Bands : public ::testing::TestWithParam<Walk> {
 protected:
  PictureRgb8 picture(const diaphane::v1::Scene& scene, Canvas canvas) {
    Method method;
    method.walk = GetParam();
    auto made = *engine_->renderer(volume_, 7, 0, method);
    const auto set = made->set_scene(scene, canvas);
    EXPECT_TRUE(set) << set.error().message;
    EXPECT_TRUE(made->render(4, nullptr));
    PictureRgb8 out;
    EXPECT_TRUE(made->display(out));
    return out;
  }
  void expect_bands_to_be_the_whole(const diaphane::v1::Scene& scene) {
    const PictureRgb8 whole = picture(scene, {kWidth, kHeight});
    for (const std::uint32_t rows : {16u, 32u, 50u, kHeight}) {
      std::vector<std::uint8_t> joined;
      for (std::uint32_t row = 0; row < kHeight; row += rows) {
        const PictureRgb8 band =
            picture(scene, {kWidth, std::min(rows, kHeight - row), row, kHeight});
        joined.insert(joined.end(), band.pixels.begin(), band.pixels.end());
      }
      EXPECT_TRUE(joined == whole.pixels) << "bands of " << rows;
    }
  }
  std::unique_ptr<Engine> engine_ = make_cpu_engine(2);
  std::shared_ptr<const DeviceVolume> volume_ = *engine_->load(test::skull_volume());
};

TEST_P(Bands, ReproduceTheWholeImageBitByBit) { expect_bands_to_be_the_whole(test::skull_scene()); }

TEST_P(Bands, ReproduceTheWholeImageForLensAndParallelRays) {
  auto scene = test::skull_scene();
  scene.mutable_camera()->set_aperture_radius(5);
  expect_bands_to_be_the_whole(scene);
  scene.mutable_camera()->set_aperture_radius(0);
  scene.mutable_camera()->set_orthographic_height(200);
  expect_bands_to_be_the_whole(scene);
}

TEST_P(Bands, RenderImageThatIsTooLargeForAFilm) {
  const PictureRgb8 band = picture(test::skull_scene(), {16384, 1, 8192, 16384});
  EXPECT_EQ(band.size.width, 16384u);
  EXPECT_EQ(band.pixels.size(), std::size_t{3} * 16384);
}

INSTANTIATE_TEST_SUITE_P(Walks, Bands, ::testing::Values(Walk::kTracking, Walk::kExact));

}  // namespace
}  // namespace diaphane::render
