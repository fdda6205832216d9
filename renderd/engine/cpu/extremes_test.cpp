// Scenes at the limits of their settings. Every picture is finite, no sample is dropped, and known
// values are right.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "renderd/engine/cpu/engine.h"
#include "renderd/scene/presets.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr Canvas kCanvas{24, 24};

std::vector<float> rendered(const volume::Volume& volume, const diaphane::v1::Scene& scene,
                            std::uint32_t samples = 8) {
  const auto engine = make_cpu_engine(2);
  const auto renderer = engine->renderer(engine->load(volume).value(), 1, 0).value();
  const auto set = renderer->set_scene(scene, kCanvas);
  EXPECT_TRUE(set) << (set ? "" : set.error().message);
  const auto batch = renderer->render(samples, nullptr);
  EXPECT_TRUE(batch);
  EXPECT_EQ(batch->dropped_samples, 0u);
  PictureRgbF picture;
  EXPECT_TRUE(renderer->radiance(picture));
  for (const float x : picture.pixels) {
    EXPECT_TRUE(std::isfinite(x) && x >= 0);
    if (!std::isfinite(x)) break;
  }
  EXPECT_FALSE(std::isnan(renderer->progress().error));
  return picture.pixels;
}

/// Returns a scene whose only opacity is `opacity`, over all values.
diaphane::v1::Scene with_opacity(double opacity) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.mutable_transfer_function()->clear_channels();
  test::add_channel(*scene.mutable_transfer_function(), {{-32768, opacity}, {32767, opacity}});
  return scene;
}

TEST(Extremes, EmptyTransferFunctionShowsOnlyTheSky) {
  for (const auto& scene :
       {with_opacity(0), [] {
          auto off = test::skull_scene();
          off.mutable_transfer_function()->mutable_channels(0)->set_disabled(true);
          return off;
        }()}) {
    for (const float x : rendered(test::skull_volume(), scene)) ASSERT_EQ(x, 0.5f);
  }
}

TEST(Extremes, VolumesOfAnyShapeAndValueRenderFinite) {
  const std::array<std::uint32_t, 3> sizes[] = {{1, 1, 1},  {1, 30, 30}, {30, 1, 30}, {30, 30, 1},
                                                {1, 1, 30}, {8, 8, 8},   {9, 16, 17}};
  for (const auto& size : sizes) {
    for (const double value : {-32768.0, 0.0, 32767.0}) {
      const auto constant =
          test::make_volume(size, {1, 1, 1}, [value](double, double, double) { return value; });
      rendered(constant, with_opacity(1));
      rendered(constant, test::skull_scene());
    }
    // Neighbouring voxels span the whole range of values.
    rendered(test::make_volume(size, {1, 1, 1},
                               [](double x, double y, double z) {
                                 return std::fmod(x + y + z, 2) < 1 ? -32768 : 32767;
                               }),
             test::skull_scene());
  }
}

TEST(Extremes, SmallLargeAndAnisotropicVoxelsRenderFinite) {
  for (const std::array<double, 3> spacing :
       {std::array{1.0, 1.0, 20.0}, std::array{20.0, 1.0, 1.0}, std::array{1e-3, 1e-3, 1e-3},
        std::array{1e3, 1e3, 1e3}, std::array{1e-3, 1.0, 1e3}}) {
    volume::Volume volume = test::skull_volume();
    volume.header.spacing = spacing;
    const double radius = 48 * std::max({spacing[0], spacing[1], spacing[2]});
    for (const double depth : {0.1, 10.0, 1e4}) {
      diaphane::v1::Scene scene = test::skull_scene();
      scene.mutable_transfer_function()->set_extinction_per_mm(depth / radius);
      test::set_camera(scene, radius, 1.5 * radius, radius, 40);
      rendered(volume, scene);
    }
  }
}

TEST(Extremes, AnyExtinctionRendersFinite) {
  for (double extinction = 1e-6; extinction < 2e6; extinction *= 100) {
    diaphane::v1::Scene solid = with_opacity(1);
    solid.mutable_transfer_function()->set_extinction_per_mm(extinction);
    rendered(test::skull_volume(), solid);
    // If a macrocell has both clear and opaque voxels, a sample costs one step per unit of the
    // majorant's optical depth. At the upper end a picture would take minutes.
    if (extinction > 200) continue;
    diaphane::v1::Scene skull = test::skull_scene();
    skull.mutable_transfer_function()->set_extinction_per_mm(extinction);
    rendered(test::skull_volume(), skull);
  }
}

TEST(Extremes, AnyCameraPositionRendersFinite) {
  for (const double distance : {1e-5, 0.5, 24.0, 100.0, 1e6}) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {1.0, -1.0}) {
        diaphane::v1::Scene scene = test::skull_scene();
        const double at = sign * distance;
        test::set_camera(scene, axis == 0 ? at : 0, axis == 1 ? at : 0, axis == 2 ? at : 0,
                         std::min(60.0, 6000 / distance));
        test::set(scene.mutable_camera()->mutable_up(), axis == 0 ? 0 : 1, axis == 0 ? 1 : 0, 0);
        rendered(test::skull_volume(), scene, 4);
      }
    }
  }
}

TEST(Extremes, AnyFieldOfViewRendersFinite) {
  for (const double fov : {1e-3, 1.0, 120.0, 179.9}) {
    diaphane::v1::Scene scene = test::skull_scene();
    scene.mutable_camera()->set_vertical_fov_degrees(fov);
    rendered(test::skull_volume(), scene);
  }
}

TEST(Extremes, LampsOfAnySizeInsideTheVolumeRenderFinite) {
  // The box of the skull extends from -24 to 24 in z.
  for (const double z : {24.0, 23.999, 0.0, -24.0}) {
    for (const double side : {1e-5, 1.0, 100.0, 1e6}) {
      diaphane::v1::Scene scene = test::skull_scene();
      scene.clear_lights();
      test::add_lamp(scene, 0, 0, z, side, 1e12);
      rendered(test::skull_volume(), scene);
    }
  }
}

TEST(Extremes, RefusesLampWithoutAreaAndNamesTheField) {
  diaphane::v1::Scene scene = test::skull_scene();
  test::set(scene.mutable_lights(0)->mutable_rectangle()->mutable_v(), 0, 0, 0);
  const auto checked = check_scene(scene);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().field, "lights[0].rectangle.v");
}

TEST(Extremes, UnlitSceneIsBlack) {
  diaphane::v1::Scene scene = test::skull_scene();
  for (auto& light : *scene.mutable_lights()) {
    test::set(light.has_rectangle() ? light.mutable_rectangle()->mutable_radiance()
                                    : light.mutable_environment()->mutable_radiance(),
              0, 0, 0);
  }
  for (const float x : rendered(test::skull_volume(), scene)) ASSERT_EQ(x, 0.0f);
}

TEST(ErrorEstimate, FallsWithTheSquareRootOfTheSamples) {
  // Independent samples give a slope of -1/2 from 64 to 4096 samples, by least squares over powers
  // of two. The estimate itself has a spread of 4% (chi-square) over about 300 pixels with
  // contents, whose three colours are correlated. This gives the slope a standard error of 0.014,
  // and the test allows three times as much.
  const auto engine = make_cpu_engine(2);
  const auto renderer = engine->renderer(engine->load(test::skull_volume()).value(), 3, 0).value();
  ASSERT_TRUE(renderer->set_scene(test::skull_scene(), kCanvas));
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (std::uint32_t samples = 64; samples <= 4096; samples *= 2) {
    ASSERT_TRUE(renderer->render(samples - static_cast<std::uint32_t>(renderer->progress().samples),
                                 nullptr));
    const double a = std::log(samples), b = std::log(renderer->progress().error);
    n += 1;
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
  }
  EXPECT_NEAR((n * xy - x * y) / (n * xx - x * x), -0.5, 0.042);
}

}  // namespace
}  // namespace diaphane::render
