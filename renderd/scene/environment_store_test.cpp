#include "renderd/scene/environment_store.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "common/ids.h"
#include "renderd/kernel/environment.h"
#include "renderd/math/random.h"
#include "renderd/scene/lights.h"
#include "renderd/scene/texture_store.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

namespace fs = std::filesystem;

struct StoredEnvironment : testing::Test {
  StoredEnvironment() {
    fs::create_directories(folder);
    set_environment_directory(folder.string());
  }
  ~StoredEnvironment() override {
    set_environment_directory({});
    fs::remove_all(folder);
  }
  std::string store(const scene::EnvironmentPicture& picture) const {
    std::string id = new_id();
    std::ofstream(folder / (id + ".hdr"), std::ios::binary) << scene::write_environment(picture);
    return id;
  }
  static diaphane::v1::Scene lit_by(const std::string& id, double radiance = 1) {
    diaphane::v1::Scene scene = test::skull_scene();
    scene.clear_lights();
    test::set_camera(scene, 0, -300, 0, 30);
    test::add_sky(scene, radiance);
    scene.mutable_lights(0)->mutable_environment()->set_stored(id);
    return scene;
  }
  static Result<PreparedLights> prepare(
      const diaphane::v1::Scene& scene,
      const std::shared_ptr<const PreparedTextures>& before = nullptr) {
    return prepare_lights(scene, CameraAxes(scene.camera()),
                          WorldToFrame(test::skull_volume().header), before);
  }
  static LightsView view_of(const PreparedLights& lights) {
    LightsView view{};
    view.map_count = static_cast<std::uint32_t>(lights.maps.size());
    view.maps = lights.maps.data();
    view.textures = lights.textures->textures.data();
    view.texels = lights.textures->texels.data();
    view.rows = lights.textures->rows.data();
    return view;
  }

  const fs::path folder = fs::temp_directory_path() / ("diaphane-environments-" + random_hex(8));
};

scene::EnvironmentPicture constant(float radiance) {
  return {64, 32, std::vector(64 * 32, scene::to_rgbe(radiance, radiance, radiance))};
}

/// A sky of 1 with a single pixel of 10^5, whose share of the light is about two thirds.
constexpr std::uint32_t kSunColumn = 700, kSunRow = 150;
scene::EnvironmentPicture with_sun() {
  scene::EnvironmentPicture picture{1024, 512, std::vector(1024 * 512, scene::to_rgbe(1, 1, 1))};
  picture.pixels[kSunColumn + 1024 * kSunRow] = scene::to_rgbe(1e5f, 1e5f, 1e5f);
  return picture;
}

TEST_F(StoredEnvironment, ConstantOneHasItsRadianceInEveryDirection) {
  const auto lights = prepare(lit_by(store(constant(1)), 3));
  ASSERT_TRUE(lights) << lights.error().message;
  test::Moments flux;
  Random random(1, 2, 3);
  for (int n = 0; n < 100'000; ++n) {
    const auto u = random.two();
    const Float3 direction = sample_maps(view_of(*lights), u.a, u.b);
    const MapsHit hit = meet_maps(view_of(*lights), direction);
    ASSERT_FLOAT_EQ(hit.radiance.y, 3);
    flux.add(static_cast<double>(hit.radiance.y / hit.density));
  }
  EXPECT_NEAR(flux.mean, 12 * std::numbers::pi,
              test::critical_z(1e-3) * flux.error_of_mean() + 1e-3);
}

TEST_F(StoredEnvironment, SamplesASunWithoutBiasOrFireflies) {
  const auto lights = prepare(lit_by(store(with_sun())));
  ASSERT_TRUE(lights) << lights.error().message;
  const LightsView view = view_of(*lights);
  // Interpolation spreads the sun over neighbours, but keeps its integral but for the rows' sines.
  const double row = std::numbers::pi * (kSunRow + 0.5) / 512;
  const double pixel = 2 * std::numbers::pi / 1024 * std::numbers::pi / 512 * std::sin(row);
  const double exact = 4 * std::numbers::pi + pixel * (1e5 - 1);
  test::Moments drawn;
  double largest = 0;
  Random random(1, 2, 3);
  for (int n = 0; n < 1'000'000; ++n) {
    const auto u = random.two();
    const MapsHit hit = meet_maps(view, sample_maps(view, u.a, u.b));
    ASSERT_GT(hit.density, 0.0f);
    const double weight = static_cast<double>(hit.radiance.y) / static_cast<double>(hit.density);
    drawn.add(weight);
    largest = std::max(largest, weight);
  }
  EXPECT_NEAR(drawn.mean, exact, test::critical_z(1e-3) * drawn.error_of_mean() + 2e-3 * exact);
  EXPECT_LT(drawn.variance(), 0.5 * exact * exact);
  EXPECT_LT(largest, 20 * exact) << "no sample outweighs the others";
}

TEST_F(StoredEnvironment, TurnsToTheRightAboutTheAxisUp) {
  scene::EnvironmentPicture picture = constant(0.5f);
  for (std::uint32_t j = 14; j < 18; ++j) {
    for (std::uint32_t i = 30; i < 34; ++i) picture.pixels[i + 64 * j] = scene::to_rgbe(9, 9, 9);
  }
  diaphane::v1::Scene scene = lit_by(store(picture));
  for (const double degrees : {0.0, 90.0, -90.0}) {
    scene.mutable_lights(0)->mutable_environment()->set_rotation_degrees(degrees);
    const auto lights = prepare(scene);
    ASSERT_TRUE(lights);
    const double turn = degrees * std::numbers::pi / 180;
    // Forward is +y and right is +x.
    const Float3 middle{static_cast<float>(std::sin(turn)), static_cast<float>(std::cos(turn)), 0};
    EXPECT_NEAR(meet_maps(view_of(*lights), middle).radiance.x, 9, 0.1) << degrees;
    EXPECT_NEAR(meet_maps(view_of(*lights), middle * -1.0f).radiance.x, 0.5, 0.01) << degrees;
  }
}

TEST_F(StoredEnvironment, LightIsUniformWhereTheEnvironmentIsGone) {
  const auto lights = prepare(lit_by(new_id(), 2));
  ASSERT_TRUE(lights) << lights.error().message;
  ASSERT_EQ(lights->maps.size(), 1u);
  for (const Float3 direction : {Float3{1, 0, 0}, Float3{0, 0, -1}, Float3{0.6f, 0, 0.8f}}) {
    EXPECT_FLOAT_EQ(meet_maps(view_of(*lights), direction).radiance.z, 2);
  }
}

TEST_F(StoredEnvironment, IsReadOnceAndStaysWhileItIsInUse) {
  const std::string id = store(constant(1));
  const auto first = prepare(lit_by(id));
  ASSERT_TRUE(first);
  fs::remove(folder / (id + ".hdr"));
  const auto again = prepare(lit_by(id, 5));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->textures, first->textures);
  EXPECT_LT(texture_memory(), 64U * 32 * 20);
}

TEST_F(StoredEnvironment, RefusesDamagedFilesAndNamesTheField) {
  const std::string id = store(constant(1));
  std::ofstream(folder / (id + ".hdr"), std::ios::binary | std::ios::app) << "more";
  const auto refused = prepare(lit_by(id));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "lights[0].environment.stored");
  EXPECT_EQ(texture_memory(), 0U);
  set_environment_directory({});
  EXPECT_FALSE(prepare(lit_by(store(constant(1))))) << "a command line has no store";
}

}  // namespace
}  // namespace diaphane::render
