#include "renderd/scene/lights.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "renderd/kernel/environment.h"
#include "renderd/kernel/lights.h"
#include "renderd/math/random.h"
#include "renderd/scene/prepared_scene.h"
#include "renderd/scene/presets.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"
#include "tests/support/renderd/test_textures.h"

namespace diaphane::render {
namespace {

using Scene = diaphane::v1::Scene;

/// A scene without lights, seen from the front, so that right and up are the same for the world and
/// the camera.
Scene dark_scene() {
  Scene scene = test::skull_scene();
  scene.clear_lights();
  test::set_camera(scene, 0, -300, 0, 30);
  return scene;
}

/// A volume whose frame differs from the world only in its origin.
volume::Header header() { return test::skull_volume().header; }
const Float3 kMiddle{24, 24, 24};  ///< centre of the box in its frame, mm

Result<PreparedLights> prepare(const Scene& scene,
                               const std::shared_ptr<const PreparedTextures>& before = nullptr) {
  return prepare_lights(scene, CameraAxes(scene.camera()), WorldToFrame(header()), before);
}

LightsView view_of_lights(const PreparedLights& lights) {
  LightsView view{.area = lights.area.data(),
                  .count = static_cast<std::uint32_t>(lights.area.size()),
                  .environment = lights.environment,
                  .map_count = static_cast<std::uint32_t>(lights.maps.size()),
                  .maps = lights.maps.data()};
  if (lights.textures) {
    view.textures = lights.textures->textures.data();
    view.texels = lights.textures->texels.data();
    view.rows = lights.textures->rows.data();
  }
  return view;
}

void add_ball(Scene& scene, double x, double radius, double radiance) {
  auto* s = scene.add_lights()->mutable_sphere();
  test::set(s->mutable_centre(), x, 100, 50);
  s->set_radius(radius);
  test::set(s->mutable_radiance(), radiance, radiance, radiance);
}

void add_picture_sky(Scene& scene, const std::string& file, double radiance = 1) {
  test::add_sky(scene, radiance);
  scene.mutable_lights(scene.lights_size() - 1)
      ->mutable_environment()
      ->mutable_texture()
      ->set_picture(file);
}

TEST(PrepareLights, OmitsLightsThatEmitNothing) {
  Scene scene = dark_scene();
  add_ball(scene, 0, 10, 0);
  add_ball(scene, 0, 10, 1);
  scene.mutable_lights(1)->set_disabled(true);
  test::add_sky(scene, 3);
  scene.mutable_lights(2)->set_disabled(true);
  const auto lights = prepare(scene);
  ASSERT_TRUE(lights);
  EXPECT_TRUE(lights->area.empty());
  EXPECT_EQ(features_of(*lights), Features{});
}

TEST(PrepareLights, IntensityScalesTheRadianceAndDefaultsToOne) {
  Scene scene = dark_scene();
  add_ball(scene, 0, 10, 3);
  add_ball(scene, 50, 10, 3);
  scene.mutable_lights(1)->set_intensity(0.5);
  test::add_sky(scene, 2);
  scene.mutable_lights(2)->set_intensity(4);
  const auto lights = prepare(scene);
  ASSERT_TRUE(lights);
  EXPECT_FLOAT_EQ(lights->area[0].radiance.y, 3);
  EXPECT_FLOAT_EQ(lights->area[1].radiance.y, 1.5f);
  EXPECT_FLOAT_EQ(lights->environment.y, 8);
}

/// A sixteenth of the probability is distributed evenly, the rest by radiance times area (a
/// sphere's whole surface).
TEST(PrepareLights, ProbabilitiesFollowThePower) {
  Scene scene = dark_scene();
  add_ball(scene, 0, 10, 3);
  test::add_lamp(scene, 0, 0, 90, 20, 5);
  const auto lights = prepare(scene);
  ASSERT_TRUE(lights);
  const double ball = 4 * std::numbers::pi * 100 * 3, lamp = 400 * 5;
  EXPECT_NEAR(lights->area[0].probability, 15.0 / 16 * ball / (ball + lamp) + 1.0 / 32, 1e-6);
  EXPECT_EQ(lights->area[0].probability + lights->area[1].probability, 1.0f);
}

/// Thousands of lights, some 1e9 times as strong as others: each is sampled with exactly the
/// probability by which its light is divided.
TEST(PrepareLights, ProbabilitiesOfThousandsOfLightsAreExact) {
  Scene scene = dark_scene();
  for (int i = 0; i < 4096; ++i) {
    auto* b = scene.add_lights()->mutable_box();
    test::set(b->mutable_corner(), i, 200, 0);
    test::set(b->mutable_u(), 1, 0, 0);
    test::set(b->mutable_v(), 0, 1, 0);
    test::set(b->mutable_w(), 0, 0, 1);
    const double radiance = i % 100 == 0 ? 1e9 : 1;
    test::set(b->mutable_radiance(), radiance, radiance, radiance);
  }
  ASSERT_TRUE(check_scene(scene));
  const auto lights = prepare(scene);
  ASSERT_TRUE(lights);
  ASSERT_EQ(lights->area.size(), 6u * 4096);
  float before = 0;
  for (const AreaLight& light : lights->area) {
    ASSERT_GT(light.probability, 0.0f);
    ASSERT_EQ(light.cumulative - before, light.probability);
    before = light.cumulative;
  }
  EXPECT_EQ(before, 1.0f);
}

TEST(BoxLight, BecomesSixRectanglesThatShineOutwards) {
  // A right-handed and a mirrored parallelepiped.
  for (const double side : {40.0, -40.0}) {
    Scene scene = dark_scene();
    auto* b = scene.add_lights()->mutable_box();
    test::set(b->mutable_corner(), 100, 20, 30);
    test::set(b->mutable_u(), side, 5, 0);
    test::set(b->mutable_v(), 0, 30, 4);
    test::set(b->mutable_w(), 3, 0, 20);
    test::set(b->mutable_radiance(), 1, 1, 1);
    const auto lights = prepare(scene);
    ASSERT_TRUE(lights);
    ASSERT_EQ(lights->area.size(), 6u);
    EXPECT_FALSE(features_of(*lights).has(Feature::kShapedLights));
    const Float3 centre =
        kMiddle + Float3{100, 20, 30} + Float3{static_cast<float>(side) + 3, 35, 24} * 0.5f;
    double area = 0;
    Double3 closed{};
    for (const AreaLight& face : lights->area) {
      const Float3 middle = face.corner + face.u * 0.5f + face.v * 0.5f;
      EXPECT_GT(dot(middle - centre, face.normal), 1.0f);
      area += static_cast<double>(face.area);
      closed += to_double(face.normal) * static_cast<double>(face.area);
    }
    EXPECT_LT(length(closed), 1e-3 * area) << "a closed surface";
  }
}

TEST(CameraLockedLights, EveryShapeTurnsWithTheCamera) {
  Scene scene = dark_scene();
  const std::string file = test::png(4, 2, [](auto i, auto) {
    return test::Rgb8{static_cast<std::uint8_t>(60 * i), 50, 50};
  });
  add_ball(scene, 70, 10, 1);
  auto* d = scene.add_lights()->mutable_disk();
  test::set(d->mutable_centre(), 30, 60, 90);
  test::set(d->mutable_normal(), 1, -2, -3);
  d->set_radius(9);
  test::set(d->mutable_radiance(), 1, 1, 1);
  auto* b = scene.add_lights()->mutable_box();
  test::set(b->mutable_corner(), 100, 20, 30);
  test::set(b->mutable_u(), 20, 0, 0);
  test::set(b->mutable_v(), 0, 30, 0);
  test::set(b->mutable_w(), 0, 0, 40);
  test::set(b->mutable_radiance(), 1, 1, 1);
  if (!file.empty()) add_picture_sky(scene, file);
  for (auto& light : *scene.mutable_lights()) light.set_camera_locked(true);

  test::set_camera(scene, 120, 200, 180, 30);
  test::set(scene.mutable_camera()->mutable_target(), 5, -6, 7);
  const CameraAxes axes(scene.camera());
  const auto turned = prepare(scene);
  ASSERT_TRUE(turned);
  // Camera coordinates: right, up, towards the eye.
  const auto seen = [&](Float3 v) {
    const Double3 w = to_double(v);
    return to_float(Double3{dot(axes.right, w), dot(axes.up, w), dot(axes.back, w)});
  };
  const auto place = [&](Float3 p) { return seen(p - kMiddle - Float3{5, -6, 7}); };
  EXPECT_LT(length(place(turned->area[0].corner) - Float3{70, 100, 50}), 1e-3f);
  EXPECT_LT(length(place(turned->area[1].corner) - Float3{30, 60, 90}), 1e-3f);
  EXPECT_LT(length(seen(turned->area[1].normal) - normalize(Float3{1, -2, -3})), 1e-5f);
  EXPECT_GT(seen(turned->area[1].v).y, 0) << "the disk's texture is upright";
  EXPECT_LT(length(place(turned->area[3].corner) - Float3{100, 20, 30}), 1e-3f);
  if (file.empty()) return;
  EXPECT_LT(length(seen(turned->maps[0].right) - Float3{1, 0, 0}), 1e-5f);
  EXPECT_LT(length(seen(turned->maps[0].middle) - Float3{0, 0, -1}), 1e-5f);
  EXPECT_LT(length(seen(turned->maps[0].up) - Float3{0, 1, 0}), 1e-5f);
}

#if defined(DIAPHANE_HAVE_PNG)

/// A 32 x 16 picture that is red on the left, green on the right and both in the middle, and twice
/// as bright above as below.
std::string compass() {
  return test::png(32, 16, [](std::uint32_t i, std::uint32_t j) {
    const auto shade = static_cast<std::uint8_t>(j < 8 ? 255 : 188);  // 1 and 0.503
    const bool middle = i >= 14 && i < 18;
    return test::Rgb8{middle || i < 16 ? shade : std::uint8_t{0},
                      middle || i >= 16 ? shade : std::uint8_t{0}, 0};
  });
}

/// The patient is seen from the front, so +y is forward, +x right and +z up.
TEST(EnvironmentMap, IsOrientedLikeTheImageWhenLookingForward) {
  Scene scene = dark_scene();
  add_picture_sky(scene, compass());
  const auto lights = prepare(scene);
  ASSERT_TRUE(lights);
  const auto towards = [&](Float3 direction) {
    return meet_maps(view_of_lights(*lights), normalize(direction)).radiance;
  };
  const Float3 ahead = towards({0, 1, 0.2f}), right = towards({1, 0, 0.2f});
  const Float3 left = towards({-1, 0, 0.2f}), down = towards({1, 0.1f, -3});
  EXPECT_NEAR(ahead.x, 1, 1e-5f);
  EXPECT_NEAR(ahead.y, 1, 1e-5f);
  EXPECT_NEAR(right.x, 0, 1e-5f);
  EXPECT_NEAR(right.y, 1, 1e-5f);
  EXPECT_NEAR(left.x, 1, 1e-5f);
  EXPECT_NEAR(left.y, 0, 1e-5f);
  EXPECT_NEAR(down.y, 0.503f, 1e-3f) << "sRGB made linear";
}

TEST(TexturedLights, DiskAndSphereTexturesFaceTheLitSide) {
  Scene scene = dark_scene();
  auto* d = scene.add_lights()->mutable_disk();
  test::set(d->mutable_normal(), 0, -1, 0);  // towards the viewer
  d->set_radius(10);
  test::set(d->mutable_radiance(), 1, 1, 1);
  d->mutable_texture()->set_picture(compass());
  add_ball(scene, 0, 10, 1);
  auto* s = scene.mutable_lights(1)->mutable_sphere();
  test::set(s->mutable_centre(), 0, 0, 0);
  s->mutable_texture()->set_picture(compass());
  const auto lights = prepare(scene);
  ASSERT_TRUE(lights);
  constexpr Features kAll = Features{}.with(Feature::kShapedLights).with(Feature::kTexturedLights);
  for (const AreaLight& light : lights->area) {
    const auto colour = [&](float x, float z) {
      const LightHit hit =
          meet_light<kAll>(view_of_lights(*lights), light, kMiddle + Float3{x, -500, z}, {0, 1, 0});
      EXPECT_TRUE(hit.met);
      return hit.radiance;
    };
    EXPECT_NEAR(colour(-6, 3).x, 1, 1e-4f) << "left";
    EXPECT_NEAR(colour(-6, 3).y, 0, 1e-4f);
    EXPECT_NEAR(colour(6, 3).y, 1, 1e-4f) << "right";
    EXPECT_NEAR(colour(6, 3).x, 0, 1e-4f);
    EXPECT_NEAR(colour(6, -3).y, 0.503f, 1e-3f) << "below";
    EXPECT_NEAR(colour(0, 3).x, 1, 1e-4f);
    EXPECT_NEAR(colour(0, 3).y, 1, 1e-4f) << "the middle";
  }
}

/// A rectangle and a disk in front of the patient that project onto a square of 200 mm.
Scene projectors() {
  Scene scene = dark_scene();
  const double degrees = 2 * std::atan(100.0 / 500) * 180 / std::numbers::pi;
  auto* r = scene.add_lights()->mutable_rectangle();
  test::set(r->mutable_corner(), -30, -500, 20);
  test::set(r->mutable_u(), 60, 0, 0);
  test::set(r->mutable_v(), 0, 0, -40);
  test::set(r->mutable_radiance(), 1, 1, 1);
  r->mutable_texture()->set_picture(compass());
  r->mutable_texture()->set_projection_degrees(degrees);
  auto* d = scene.add_lights()->mutable_disk();
  test::set(d->mutable_centre(), 0, -500, 0);
  test::set(d->mutable_normal(), 0, 1, 0);
  d->set_radius(20);
  test::set(d->mutable_radiance(), 1, 1, 1);
  *d->mutable_texture() = r->texture();
  return scene;
}

TEST(TexturedLights, ProjectTheTextureUprightAndInFocusThroughTheOrigin) {
  const auto lights = prepare(projectors());
  ASSERT_TRUE(lights);
  ASSERT_EQ(lights->area.size(), 2u);
  constexpr Features kAll = Features{}.with(Feature::kShapedLights).with(Feature::kTexturedLights);
  for (const AreaLight& light : lights->area) {
    const auto colour = [&](float x, float z, Float3 from) {
      const Float3 to = Float3{from.x - x, -500, from.z - z};
      const LightHit hit = meet_light<kAll>(view_of_lights(*lights), light,
                                            kMiddle + Float3{x, 0, z}, normalize(to));
      EXPECT_TRUE(hit.met);
      return hit.radiance;
    };
    for (const Float3 from : {Float3{0, 0, 0}, Float3{-14, 0, 9}, Float3{12, 0, -11}}) {
      EXPECT_NEAR(colour(-60, 40, from).x, 1, 1e-4f) << "left";
      EXPECT_NEAR(colour(-60, 40, from).y, 0, 1e-4f);
      EXPECT_NEAR(colour(60, 40, from).y, 1, 1e-4f) << "right";
      EXPECT_NEAR(colour(60, -40, from).y, 0.503f, 1e-3f) << "below";
      EXPECT_EQ(colour(101, 0, from).y, 0) << "beside the picture";
      EXPECT_EQ(colour(0, -101, from).y, 0);
    }
    for (const float u : {0.1f, 0.5f, 0.8f}) {
      const LightSample s =
          sample_light<kAll>(view_of_lights(*lights), light, kMiddle + Float3{60, 0, -40}, u, 0.7f);
      EXPECT_NEAR(s.irradiance.y * s.density * light.probability, 0.503f, 1e-3f);
    }
  }
}

TEST(TexturedLights, ProbabilityFollowsTheMeanOfTheTexture) {
  Scene scene = dark_scene();
  test::add_lamp(scene, 0, 0, 90, 20, 5);
  test::add_lamp(scene, 0, 0, 90, 20, 5);
  scene.mutable_lights(1)->mutable_rectangle()->mutable_texture()->set_picture(
      test::png(10, 10, [](auto i, auto) {
        const auto v = static_cast<std::uint8_t>(i < 3 ? 255 : 0);
        return test::Rgb8{v, v, v};
      }));
  const auto lights = prepare(scene);
  ASSERT_TRUE(lights);
  EXPECT_NEAR(lights->area[1].probability, 15.0 / 16 * 0.3 / 1.3 + 1.0 / 32, 1e-6);
  scene.mutable_lights(1)->mutable_rectangle()->mutable_texture()->set_picture(
      test::png(10, 10, [](auto, auto) {
        return test::Rgb8{0, 0, 0};
      }));
  EXPECT_EQ(prepare(scene)->area.size(), 1u) << "black";
}

/// A dim picture with a few very bright texels, some black ones and no symmetry.
std::string spotted() {
  return test::png(23, 11, [](std::uint32_t i, std::uint32_t j) {
    if ((i == 17 && j == 2) || (i == 0 && j == 5) || (i == 22 && j == 9)) {
      return test::Rgb8{255, 250, 200};
    }
    if (j == 7 || i % 7 == 3) return test::Rgb8{0, 0, 0};
    return test::Rgb8{static_cast<std::uint8_t>(3 * i), 40, static_cast<std::uint8_t>(9 * j)};
  });
}

Scene two_skies() {
  Scene scene = dark_scene();
  test::set_camera(scene, 120, 200, 180, 30);
  add_picture_sky(scene, spotted());
  add_picture_sky(scene, compass(), 0.1);
  scene.mutable_lights(1)->set_camera_locked(true);
  return scene;
}

/// Resolution of integrals over the sphere by the midpoint rule. The steps are not multiples of the
/// texels.
constexpr int kPolar = 1010, kTurn = 2020;
template <typename Function>
void over_sphere(const Function& function) {
  for (int j = 0; j < kPolar; ++j) {
    for (int i = 0; i < kTurn; ++i) {
      const double z = 1 - 2 * (j + 0.5) / kPolar;
      const double r = std::sqrt(1 - z * z), turn = 2 * std::numbers::pi * (i + 0.5) / kTurn;
      function(to_float(Double3{r * std::cos(turn), r * std::sin(turn), z}), j, i);
    }
  }
}
constexpr double kPatch = 4 * std::numbers::pi / kPolar / kTurn;  // steradians

TEST(EnvironmentMap, SampledDirectionsFollowTheDensity) {
  constexpr int kSamples = 1'000'000, kBins = 101;
  const auto lights = prepare(two_skies());
  ASSERT_TRUE(lights);
  const LightsView view = view_of_lights(*lights);
  std::array<double, kBins> polar{}, turn{};
  double all = 0;
  over_sphere([&](Float3 d, int j, int i) {
    const double p = static_cast<double>(meet_maps(view, d).density) * kPatch;
    all += p;
    polar[static_cast<std::size_t>(j * kBins / kPolar)] += p;
    turn[static_cast<std::size_t>(i * kBins / kTurn)] += p;
  });
  EXPECT_NEAR(all, 1, 2e-3);
  for (double& p : polar) p /= all;
  for (double& p : turn) p /= all;
  std::array<std::uint64_t, kBins> polar_counts{}, turn_counts{};
  Random random(1, 2, 3);
  for (int n = 0; n < kSamples; ++n) {
    const Random::Pair u = random.two();
    const Double3 d = to_double(sample_maps(view, u.a, u.b));
    ASSERT_NEAR(dot(d, d), 1, 1e-5);
    const auto bin = [](double x) {
      return static_cast<std::size_t>(std::clamp(x * kBins, 0.0, kBins - 0.5));
    };
    ++polar_counts[bin((1 - d.z) / 2)];
    const double angle = std::atan2(d.y, d.x) / (2 * std::numbers::pi);
    ++turn_counts[bin(angle < 0 ? angle + 1 : angle)];
  }
  // The error of the midpoint rule is 0.3% in a bin that the edge of a bright texel crosses, which
  // 1e6 samples do not resolve.
  const double alpha = test::sidak(1e-3, 2);
  EXPECT_TRUE(test::chi_square(polar_counts, polar, kSamples).fits(alpha))
      << test::chi_square(polar_counts, polar, kSamples).value;
  EXPECT_TRUE(test::chi_square(turn_counts, turn, kSamples).fits(alpha))
      << test::chi_square(turn_counts, turn, kSamples).value;
}

TEST(EnvironmentMap, ImportanceSamplingIsUnbiasedWithLowVariance) {
  const auto lights = prepare(two_skies());
  ASSERT_TRUE(lights);
  const LightsView view = view_of_lights(*lights);
  double exact = 0;
  over_sphere([&](Float3 d, int, int) {
    exact += static_cast<double>(meet_maps(view, d).radiance.y) * kPatch;
  });
  test::Moments drawn;
  Random random(1, 2, 3);
  for (int n = 0; n < 1'000'000; ++n) {
    const Random::Pair u = random.two();
    const MapsHit hit = meet_maps(view, sample_maps(view, u.a, u.b));
    ASSERT_GT(hit.density, 0.0f);
    drawn.add(static_cast<double>(hit.radiance.y) / static_cast<double>(hit.density));
  }
  EXPECT_NEAR(drawn.mean, exact, test::critical_z(1e-3) * drawn.error_of_mean() + 1e-4 * exact);
  EXPECT_LT(drawn.variance(), 0.5 * exact * exact);
}

TEST(PrepareTextures, SharesTexturesBetweenScenesAndLights) {
  Scene scene = two_skies();
  test::add_lamp(scene, 0, 0, 90, 20, 5);
  scene.mutable_lights(2)->mutable_rectangle()->mutable_texture()->set_picture(spotted());
  const auto first = prepare(scene);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->textures->textures.size(), 2u) << "one file twice";
  EXPECT_EQ(first->textures->texels.size(), 23u * 11 + 32 * 16);
  test::set_camera(scene, -45, 80, 28, 30);
  const auto again = prepare(scene, first->textures);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->textures, first->textures);
  scene.mutable_lights(1)->mutable_environment()->clear_texture();
  const auto fewer = prepare(scene, first->textures);
  ASSERT_TRUE(fewer);
  EXPECT_NE(fewer->textures, first->textures);
  EXPECT_EQ(fewer->textures->texels.size(), 23u * 11);
  EXPECT_EQ(fewer->textures->texels[100].x, first->textures->texels[100].x);
  scene.clear_lights();
  EXPECT_EQ(prepare(scene, first->textures)->textures, nullptr);
}

TEST(PrepareTextures, NamesTheDamagedOrExcessiveTexture) {
  Scene scene = dark_scene();
  add_ball(scene, 0, 10, 1);
  auto* d = scene.add_lights()->mutable_disk();
  test::set(d->mutable_normal(), 0, -1, 0);
  d->set_radius(10);
  test::set(d->mutable_radiance(), 1, 1, 1);
  d->mutable_texture()->set_picture(spotted().substr(0, 150));
  ASSERT_TRUE(check_scene(scene)) << "the header is valid";
  const auto damaged = prepare(scene);
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().code, ErrorCode::kInvalid);
  EXPECT_EQ(damaged.error().field, "lights[1].disk.texture");
  EXPECT_NE(damaged.error().message.find("corrupted"), std::string::npos);
  // These have many pixels but few bytes, and are refused before anything is decoded.
  const auto large = [](std::uint8_t shade) {
    return test::png(4096, 2100, [shade](auto, auto) { return test::Rgb8{shade, 0, 0}; });
  };
  d->mutable_texture()->set_picture(large(1));
  add_picture_sky(scene, large(2));
  const auto much = prepare(scene);
  ASSERT_FALSE(much);
  EXPECT_EQ(much.error().field, "lights[2].environment.texture");
}

#endif

}  // namespace
}  // namespace diaphane::render
