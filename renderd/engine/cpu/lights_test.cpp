// Lights in whole pictures. If two pictures must have the same mean, Welch's t compares each tile
// of 8 x 8 pixels. One observation is the mean over a tile of one small picture, and there are
// kPictures of each. The significance is 1e-4 over all tiles (Sidak), with fixed seeds.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "renderd/engine/cpu/engine.h"
#include "renderd/kernel/estimator.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"
#include "tests/support/renderd/test_textures.h"

namespace diaphane::render {
namespace {

using Scene = diaphane::v1::Scene;
using Tiles = std::vector<test::Moments>;

constexpr Canvas kCanvas{24, 16};
constexpr std::uint32_t kTile = 8, kSamples = 8;
const std::uint32_t kPictures = test::gate_or_nightly(24u, 64u);
constexpr double kAlpha = 1e-4;

std::vector<float> picture_of(const Scene& scene, Method method = {}, std::uint64_t first = 0,
                              std::uint32_t samples = kSamples) {
  static const auto engine = make_cpu_engine(2);
  static const auto loaded = engine->load(test::skull_volume()).value();
  const auto one = engine->renderer(loaded, 5, first, method).value();
  const auto set = one->set_scene(scene, kCanvas);
  EXPECT_TRUE(set) << (set ? "" : set.error().message);
  const auto batch = one->render(samples, [] { return false; });
  EXPECT_TRUE(batch && batch->dropped_samples == 0);
  PictureRgbF out;
  EXPECT_TRUE(one->radiance(out));
  return out.pixels;
}

void add_picture(Tiles& tiles, const std::vector<float>& rgb) {
  std::vector<double> sums(tiles.size());
  for (std::uint32_t y = 0; y < kCanvas.height; ++y) {
    for (std::uint32_t x = 0; x < kCanvas.width; ++x) {
      const std::size_t pixel = x + kCanvas.width * y;
      sums[x / kTile + kCanvas.width / kTile * (y / kTile)] +=
          static_cast<double>(rgb[3 * pixel] + rgb[3 * pixel + 1] + rgb[3 * pixel + 2]);
    }
  }
  for (std::size_t i = 0; i < tiles.size(); ++i) tiles[i].add(sums[i]);
}
Tiles no_tiles() { return Tiles((kCanvas.width / kTile) * (kCanvas.height / kTile)); }

/// `first` keeps the samples of two sets disjoint.
Tiles tiles_of(const Scene& scene, Method method, std::uint64_t first) {
  Tiles tiles = no_tiles();
  for (std::uint32_t i = 0; i < kPictures; ++i) {
    add_picture(tiles, picture_of(scene, method, first + std::uint64_t{i} * kSamples));
  }
  return tiles;
}

void expect_same(const Tiles& a, const Tiles& b, const std::string& what) {
  const double critical = test::critical_t(test::sidak(kAlpha, a.size()), kPictures - 1);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_LT(std::abs(test::welch(a[i], b[i])), critical)
        << what << ", tile " << i << ": " << a[i].mean << " and " << b[i].mean;
  }
}

Scene dark_scene() {
  Scene scene = test::skull_scene();
  scene.clear_lights();
  return scene;
}

std::string panorama() {
  return test::png(24, 12, [](std::uint32_t i, std::uint32_t j) {
    if (i == 15 && j == 3) return test::Rgb8{255, 250, 220};
    return test::Rgb8{static_cast<std::uint8_t>(40 + 4 * i), 70, static_cast<std::uint8_t>(12 * j)};
  });
}

/// A scene with a light of every shape, with textures if they are supported.
Scene every_light() {
  Scene scene = dark_scene();
  test::add_lamp(scene, -20, 15, 70, 40, 10);
  auto* d = scene.add_lights()->mutable_disk();
  test::set(d->mutable_centre(), 40, 40, 0);
  test::set(d->mutable_normal(), -1, -1, 0);
  d->set_radius(15);
  test::set(d->mutable_radiance(), 8, 5, 3);
  auto* s = scene.add_lights()->mutable_sphere();
  test::set(s->mutable_centre(), 30, -20, 40);
  s->set_radius(12);
  test::set(s->mutable_radiance(), 3, 5, 9);
  auto* b = scene.add_lights()->mutable_box();
  test::set(b->mutable_corner(), -50, 30, -20);
  test::set(b->mutable_u(), 10, 0, 0);
  test::set(b->mutable_v(), 0, 10, 0);
  test::set(b->mutable_w(), 0, 0, 40);
  test::set(b->mutable_radiance(), 6, 6, 2);
  test::add_sky(scene, 0.2);
  if (panorama().empty()) return scene;
  for (auto* texture : {scene.mutable_lights(0)->mutable_rectangle()->mutable_texture(),
                        d->mutable_texture(), s->mutable_texture()}) {
    texture->set_picture(panorama());
  }
  test::add_sky(scene, 1.5);
  scene.mutable_lights(5)->mutable_environment()->mutable_texture()->set_picture(panorama());
  return scene;
}

TEST(Lights, EverySamplingStrategyHasTheSameMean) {
  for (const double g : {0.8, -0.5}) {
    Scene scene = every_light();
    scene.mutable_phase()->set_g(g);
    const Tiles both = tiles_of(scene, {}, 0);
    expect_same(both, tiles_of(scene, {.mis = Mis::kLight}, 100'000), "light");
    // Sampling only the scattering directions hits lamps too rarely for Welch's test, so this
    // compares the environment alone. kernel/direct_test.cpp tests all lights.
    scene.mutable_lights()->DeleteSubrange(0, 4);
    expect_same(tiles_of(scene, {}, 200'000), tiles_of(scene, {.mis = Mis::kScatter}, 300'000),
                "scatter");
  }
}

TEST(Lights, StrategiesAgreeWithGlossAndManyBounces) {
  Scene scene = every_light();
  scene.mutable_shading()->set_mode(diaphane::v1::Shading::HYBRID);
  auto* channel = scene.mutable_transfer_function()->mutable_channels(0);
  test::set(channel->mutable_specular(), 0.3, 0.3, 0.3);
  channel->set_gloss(0.5);
  scene.mutable_phase()->set_g(0.4);
  scene.set_bounces(4);
  expect_same(tiles_of(scene, {}, 0), tiles_of(scene, {.mis = Mis::kLight}, 100'000), "light");
}

/// Returns one estimate of a small picture with the variant for `F`.
template <Features F>
Tiles variant_tiles(const Scene& scene, std::uint64_t seed) {
  const test::Prepared p(test::skull_volume(), scene, kCanvas);
  const auto view = p.view(seed);
  Tiles tiles = no_tiles();
  std::vector<float> rgb(3 * kCanvas.width * kCanvas.height);
  for (std::uint32_t i = 0; i < kPictures * 2; ++i) {
    for (std::uint32_t pixel = 0; pixel < kCanvas.width * kCanvas.height; ++pixel) {
      const Float3 c = estimate<F>(view, pixel % kCanvas.width, pixel / kCanvas.width, i).radiance;
      rgb[3 * pixel] = c.x;
      rgb[3 * pixel + 1] = c.y;
      rgb[3 * pixel + 2] = c.z;
    }
    add_picture(tiles, rgb);
  }
  return tiles;
}

constexpr Features kLamps = Features{}
                                .with(Feature::kAreaLights)
                                .with(Feature::kManyLights)
                                .with(Feature::kShapedLights)
                                .with(Feature::kEnvironment);
constexpr Features kEveryLight =
    kLamps.with(Feature::kTexturedLights).with(Feature::kTexturedEnvironment);

TEST(Lights, VariantWithMoreFeaturesHasTheSameMean) {
  const Scene scene = every_light();
  const Features needed = test::Prepared(test::skull_volume(), scene).scene().features;
  ASSERT_TRUE(kEveryLight.holds(needed));
  expect_same(variant_tiles<kEveryLight>(scene, 1), variant_tiles<kAllFeatures>(scene, 2),
              "all lights");
  // The smallest set of features for one lamp and a sky.
  constexpr Features kFew = Features{}.with(Feature::kAreaLights).with(Feature::kEnvironment);
  const Scene few = test::skull_scene();
  ASSERT_TRUE(kFew.holds(test::Prepared(test::skull_volume(), few).scene().features));
  const Tiles least = variant_tiles<kFew>(few, 3);
  expect_same(least, variant_tiles<kLamps>(few, 4), "shapes compiled in");
  expect_same(least, variant_tiles<kAllFeatures>(few, 5), "all compiled in");
}

/// In the exact walk each strategy has separate strata, and a strategy without strata must have no
/// weight, even if the variant could combine strategies that the scene does not.
TEST(Lights, ExactWalkMatchesTracking) {
  for (const double g : {0.0, 0.6}) {
    Scene scene = every_light();
    scene.mutable_phase()->set_g(g);
    expect_same(tiles_of(scene, {.walk = Walk::kExact}, 0),
                tiles_of(scene, {.walk = Walk::kTracking}, 100'000), "g " + std::to_string(g));
  }
}

TEST(BoxLight, EqualsTheSumOfItsSixRectangles) {
  Scene box = dark_scene(), faces = dark_scene();
  auto* b = box.add_lights()->mutable_box();
  test::set(b->mutable_corner(), 30, 25, 20);
  test::set(b->mutable_u(), 20, 0, 0);
  test::set(b->mutable_v(), 0, 15, 0);
  test::set(b->mutable_w(), 0, 0, 10);
  test::set(b->mutable_radiance(), 9, 9, 9);
  const double x0 = 30, y0 = 25, z0 = 20, u = 20, v = 15, w = 10;
  const auto face = [&](double x, double y, double z, std::array<double, 3> a,
                        std::array<double, 3> c) {
    auto* r = faces.add_lights()->mutable_rectangle();
    test::set(r->mutable_corner(), x, y, z);
    test::set(r->mutable_u(), a[0], a[1], a[2]);
    test::set(r->mutable_v(), c[0], c[1], c[2]);
    test::set(r->mutable_radiance(), 9, 9, 9);
  };
  face(x0 + u, y0, z0, {0, v, 0}, {0, 0, w});
  face(x0, y0, z0, {0, 0, w}, {0, v, 0});
  face(x0, y0 + v, z0, {0, 0, w}, {u, 0, 0});
  face(x0, y0, z0, {u, 0, 0}, {0, 0, w});
  face(x0, y0, z0 + w, {u, 0, 0}, {0, v, 0});
  face(x0, y0, z0, {0, v, 0}, {u, 0, 0});
  expect_same(tiles_of(box, {}, 0), tiles_of(faces, {}, 100'000), "box");
}

#if defined(DIAPHANE_HAVE_PNG)

/// A texture of one colour must give the same light as that colour without a texture, whatever the
/// other settings.
TEST(TexturedLights, UniformTextureEqualsAPlainLight) {
  // The sRGB value 188 is 0.5029 of white.
  const std::string grey = test::png(9, 5, [](auto, auto) { return test::Rgb8{188, 188, 188}; });
  const double half = std::pow((188 / 255.0 + 0.055) / 1.055, 2.4);
  for (const int kind : {0, 1, 2, 3}) {
    Scene plain = dark_scene();
    auto& light = *plain.add_lights();
    if (kind == 0) {
      test::add_lamp(plain, -20, 15, 70, 40, 30);
      plain.mutable_lights()->DeleteSubrange(0, 1);
    } else if (kind == 1) {
      auto* d = light.mutable_disk();
      test::set(d->mutable_centre(), 40, 40, 0);
      test::set(d->mutable_normal(), -1, -1, 0);
      d->set_radius(15);
      test::set(d->mutable_radiance(), 8, 5, 3);
    } else if (kind == 2) {
      auto* s = light.mutable_sphere();
      test::set(s->mutable_centre(), 40, 30, 10);
      s->set_radius(12);
      test::set(s->mutable_radiance(), 3, 5, 9);
    } else {
      test::set(light.mutable_environment()->mutable_radiance(), 1, 2, 3);
    }
    Scene textured = plain;
    auto& t = *textured.mutable_lights(0);
    (kind == 0   ? t.mutable_rectangle()->mutable_texture()
     : kind == 1 ? t.mutable_disk()->mutable_texture()
     : kind == 2 ? t.mutable_sphere()->mutable_texture()
                 : t.mutable_environment()->mutable_texture())
        ->set_picture(grey);
    plain.mutable_lights(0)->set_intensity(half);
    if (kind < 3) {
      const auto a = variant_tiles<kEveryLight>(plain, 1);
      const auto b = variant_tiles<kEveryLight>(textured, 1);
      // Both draw the same numbers, so the pictures are equal except for rounding.
      for (std::size_t i = 0; i < a.size(); ++i) {
        EXPECT_NEAR(a[i].mean, b[i].mean, 1e-4 * a[i].mean) << kind;
      }
      continue;
    }
    for (const double g : {0.0, 0.7}) {
      for (const std::uint32_t bounces : {1u, 3u}) {
        for (Scene* scene : {&plain, &textured}) {
          scene->mutable_phase()->set_g(g);
          scene->set_bounces(bounces);
        }
        expect_same(tiles_of(plain, {}, 0), tiles_of(textured, {}, 100'000),
                    "sky, g " + std::to_string(g) + ", bounces " + std::to_string(bounces));
      }
    }
  }
}

TEST(EnvironmentMap, IsVisibleBehindTheVolumeOnlyIfConfigured) {
  Scene scene = dark_scene();
  scene.mutable_transfer_function()->set_extinction_per_mm(0);
  test::add_sky(scene, 2);
  scene.mutable_lights(0)->mutable_environment()->mutable_texture()->set_picture(
      test::png(4, 4, [](auto, auto) {
        return test::Rgb8{255, 0, 0};
      }));
  scene.mutable_display()->set_show_environment(true);
  EXPECT_NEAR(picture_of(scene)[0], 2, 1e-5f);
  scene.mutable_display()->set_show_environment(false);
  test::set(scene.mutable_display()->mutable_background(), 0.25, 0, 0);
  EXPECT_EQ(picture_of(scene)[0], 0.25f);
}

#endif

TEST(Lights, ExtremeLightsRenderFinite) {
  const auto finite = [](const Scene& scene) {
    double sum = 0;
    for (const float x : picture_of(scene, {}, 0, 64)) {
      EXPECT_TRUE(std::isfinite(x));
      EXPECT_GE(x, 0.0f);
      sum += static_cast<double>(x);
    }
    return sum;
  };
  Scene bright = test::skull_scene();
  const double plain = finite(bright);
  for (auto& light : *bright.mutable_lights()) light.set_intensity(1e12);
  EXPECT_NEAR(finite(bright), 1e12 * plain, 1e8 * plain) << "intensity";
  // If everything is inside a sphere light, nothing of the light is visible.
  Scene inside = dark_scene();
  inside.mutable_display()->set_show_environment(false);
  auto* s = inside.add_lights()->mutable_sphere();
  s->set_radius(500);
  test::set(s->mutable_radiance(), 5, 5, 5);
  EXPECT_EQ(finite(inside), 0) << "inside a sphere";
  // Only the camera is inside the sphere.
  test::set(s->mutable_centre(), 45, 80, 28);
  s->set_radius(40);
  EXPECT_GT(finite(inside), 0) << "the camera inside a sphere";
  // These lights pass through the middle of the matter, and points are inside it.
  Scene through = every_light();
  test::add_lamp(through, 0, 0, 0, 60, 10);
  auto* point = through.add_lights()->mutable_sphere();
  test::set(point->mutable_centre(), 1, 2, 3);
  test::set(point->mutable_radiance(), 500, 500, 500);
  auto* spot = through.add_lights()->mutable_disk();
  test::set(spot->mutable_centre(), -5, 3, 2);
  test::set(spot->mutable_normal(), 0, 0, -1);
  test::set(spot->mutable_radiance(), 500, 500, 500);
  for (const double g : {0.0, 0.99, -0.9}) {
    through.mutable_phase()->set_g(g);
    EXPECT_GT(finite(through), 0) << "lights in the matter";
  }
}

}  // namespace
}  // namespace diaphane::render
