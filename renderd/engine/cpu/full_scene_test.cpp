// Compares a scene with every feature with an estimator that shares no code with the renderer
// (reference_estimator.h). The scene has several overlapping channels, an anisotropic phase
// function, rectangles in the world and locked to the camera, a sky, anisotropic voxels and an
// oblique direction matrix.
//
// Welch's t-test compares each tile of 8 x 8 pixels and each colour. One observation is the mean
// over a tile of one small picture, and each estimator makes kPictures of them. The significance is
// 1e-4 over all tiles and colours (Sidak), with fixed seeds. The last test shows which bias is
// detected.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "renderd/engine/cpu/engine.h"
#include "tests/support/renderd/optics.h"
#include "tests/support/renderd/reference_estimator.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr Canvas kCanvas{24, 16};
constexpr std::uint32_t kTile = 8, kSamples = 16;
const std::uint32_t kPictures = test::gate_or_nightly(48u, 192u);
constexpr double kAlpha = 1e-4;

volume::Volume oblique_volume() {
  volume::Volume volume =
      test::tilt(test::make_volume({20, 16, 11}, {1, 1.4, 2.3}, [](double x, double y, double z) {
        const double wave = std::sin(0.6 * x + 0.2 * z) * std::sin(0.5 * y) * std::cos(0.4 * z);
        return 500 + 500 * wave;
      }));
  // Blocks that end at and beside the faces of macrocells.
  test::mark(volume, [](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return x < 8 && z > 2 ? 1 : y < 7 ? 2 : x > 14 && y > 9 ? 3 : 0;
  });
  return volume;
}

diaphane::v1::Scene full_scene(double g) {
  diaphane::v1::Scene scene;
  auto& function = *scene.mutable_transfer_function();
  test::add_channel(function, {{300, 0}, {600, 0.4}, {800, 0}}, 0.9, 0.5, 0.4);
  test::add_channel(function, {{650, 0}, {750, 1}, {1000, 0.3}}, 0.3, 0.85, 0.9);
  test::add_channel(function, {{0, 1}, {1000, 1}}, 1, 0, 0)->set_disabled(true);
  function.set_extinction_per_mm(0.3);
  test::add_lamp(scene, 5, -8, 40, 20, 12);
  // The light is to the right of the camera and faces the target: cross(u, v) is -x.
  test::add_lamp(scene, 0, 0, 0, 1, 8);
  auto* locked = scene.mutable_lights(1);
  locked->set_camera_locked(true);
  test::set(locked->mutable_rectangle()->mutable_corner(), 35, -10, -5);
  test::set(locked->mutable_rectangle()->mutable_u(), 0, 0, 18);
  test::set(locked->mutable_rectangle()->mutable_v(), 2, 20, 0);
  test::set(scene.add_lights()->mutable_environment()->mutable_radiance(), 0.25, 0.375, 0.5);
  test::set_camera(scene, 35, -45, 25, 36);
  test::set(scene.mutable_camera()->mutable_target(), 6, -5, 4);
  scene.mutable_phase()->set_g(g);
  scene.mutable_display()->set_show_environment(g > 0);
  test::set(scene.mutable_display()->mutable_background(), 0.125, 0.25, 0.0625);
  return scene;
}

/// Three moments per tile, one for each colour.
using Tiles = std::vector<test::Moments>;

/// `colour(x, y, c)` returns means over one picture.
template <typename Colour>
void add_picture(Tiles& tiles, const Colour& colour) {
  std::vector<double> sums(tiles.size());
  for (std::uint32_t y = 0; y < kCanvas.height; ++y) {
    for (std::uint32_t x = 0; x < kCanvas.width; ++x) {
      const std::size_t tile = x / kTile + kCanvas.width / kTile * (y / kTile);
      for (std::size_t c = 0; c < 3; ++c) sums[3 * tile + c] += colour(x, y, c);
    }
  }
  for (std::size_t i = 0; i < tiles.size(); ++i) tiles[i].add(sums[i] / (kTile * kTile));
}

Tiles no_tiles() { return Tiles(3 * (kCanvas.width / kTile) * (kCanvas.height / kTile)); }

Tiles reference(const diaphane::v1::Scene& scene) {
  const volume::Volume volume = oblique_volume();
  test::ReferenceEstimator estimator(volume, scene, kCanvas, 2024);
  Tiles tiles = no_tiles();
  for (std::uint32_t picture = 0; picture < kPictures; ++picture) {
    std::vector<test::Triple> pixels(kCanvas.width * kCanvas.height);
    for (std::uint32_t pixel = 0; pixel < pixels.size(); ++pixel) {
      for (std::uint32_t i = 0; i < kSamples; ++i) {
        pixels[pixel] =
            pixels[pixel] +
            estimator.sample(pixel % kCanvas.width, pixel / kCanvas.width) * (1.0 / kSamples);
      }
    }
    add_picture(tiles, [&](std::uint32_t x, std::uint32_t y, std::size_t c) {
      return pixels[x + kCanvas.width * y][c];
    });
  }
  return tiles;
}

const Tiles& reference_of(double g) {
  static std::map<double, Tiles> known;
  if (!known.contains(g)) known.emplace(g, reference(full_scene(g)));
  return known.at(g);
}

Tiles rendered(const diaphane::v1::Scene& scene, Method method = {}) {
  const auto engine = make_cpu_engine(2);
  const auto loaded = engine->load(oblique_volume()).value();
  Tiles tiles = no_tiles();
  for (std::uint32_t picture = 0; picture < kPictures; ++picture) {
    // The pictures use disjoint ranges of one stream.
    const auto one = engine->renderer(loaded, 5, std::uint64_t{picture} * kSamples, method).value();
    EXPECT_TRUE(one->set_scene(scene, kCanvas));
    EXPECT_TRUE(one->render(kSamples, nullptr));
    PictureRgbF out;
    EXPECT_TRUE(one->radiance(out));
    add_picture(tiles, [&](std::uint32_t x, std::uint32_t y, std::size_t c) {
      return static_cast<double>(out.pixels[3 * (x + kCanvas.width * y) + c]);
    });
  }
  return tiles;
}

/// Describes the tests that reject the hypothesis of equal means.
std::vector<std::string> rejections(const Tiles& a, const Tiles& b) {
  const double critical = test::critical_t(test::sidak(kAlpha, a.size()), kPictures - 1);
  std::vector<std::string> out;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double t = test::welch(a[i], b[i]);
    if (std::abs(t) < critical) continue;
    out.push_back("tile " + std::to_string(i / 3) + " colour " + std::to_string(i % 3) + ": " +
                  std::to_string(a[i].mean) + " and " + std::to_string(b[i].mean) +
                  ", t = " + std::to_string(t));
  }
  return out;
}

TEST(FullScene, ForwardScatteringMatchesAnIndependentEstimator) {
  EXPECT_EQ(rejections(rendered(full_scene(0.5)), reference_of(0.5)), std::vector<std::string>{});
}

TEST(FullScene, BackwardScatteringMatchesAnIndependentEstimator) {
  EXPECT_EQ(rejections(rendered(full_scene(-0.4)), reference_of(-0.4)), std::vector<std::string>{});
}

/// A scene with paths of several collisions, emission, and Lambert surfaces chosen by the gradient.
diaphane::v1::Scene deep_scene() {
  diaphane::v1::Scene scene = full_scene(0.3);
  auto& function = *scene.mutable_transfer_function();
  test::set(function.mutable_channels(0)->mutable_emission(), 0.25, 0.125, 0);
  test::set(function.mutable_channels(1)->mutable_emission(), 0, 0.0625, 0.25);
  scene.mutable_shading()->set_mode(diaphane::v1::Shading::HYBRID);
  scene.mutable_shading()->set_gradient_scale(0.15);
  scene.set_bounces(5);
  return scene;
}

/// Adds looks of three labels: thinner matter of another colour, another colour, and no matter.
void add_looks(diaphane::v1::Scene& scene) {
  for (const std::uint32_t number : {10, 20, 30}) scene.add_labels()->set_number(number);
  scene.mutable_labels(0)->set_opacity(0.4);
  test::set(scene.mutable_labels(0)->mutable_colour(), 0.25, 0.75, 0.5);
  test::set(scene.mutable_labels(1)->mutable_colour(), 0.875, 0.25, 0.125);
  scene.mutable_labels(2)->set_opacity(0);
}

TEST(FullScene, LabelsMatchAnIndependentEstimator) {
  diaphane::v1::Scene scene = full_scene(0.5);
  add_looks(scene);
  EXPECT_EQ(rejections(rendered(scene), reference(scene)), std::vector<std::string>{});
  EXPECT_NE(rejections(rendered(scene), reference_of(0.5)), std::vector<std::string>{})
      << "they change the picture";
}

TEST(FullScene, DeepPathsThroughLabelsMatchAnIndependentEstimator) {
  diaphane::v1::Scene scene = deep_scene();
  add_looks(scene);
  scene.add_labels()->set_opacity(0.7);  // of the voxels of no label
  EXPECT_EQ(rejections(rendered(scene), reference(scene)), std::vector<std::string>{});
}

TEST(FullScene, ALabelAloneMatchesAnIndependentEstimator) {
  diaphane::v1::Scene scene = deep_scene();
  add_looks(scene);
  scene.mutable_labels(1)->set_solo(true);
  EXPECT_EQ(rejections(rendered(scene), reference(scene)), std::vector<std::string>{});
}

/// Tints a part of the matter that the camera sees.
void add_highlight(diaphane::v1::Scene& scene) {
  auto& highlight = *scene.mutable_highlight();
  test::set(highlight.mutable_centre(), 6, -6, 3);
  highlight.set_radius(5);
  test::set(highlight.mutable_colour(), 0.125, 0.25, 1);
  highlight.set_strength(0.875);
}

TEST(FullScene, HighlightMatchesAnIndependentEstimator) {
  diaphane::v1::Scene scene = deep_scene();
  add_highlight(scene);
  const Tiles expected = reference(scene);
  for (const Walk walk : {Walk::kExact, Walk::kTracking}) {
    EXPECT_EQ(rejections(rendered(scene, {.walk = walk}), expected), std::vector<std::string>{});
  }
  EXPECT_NE(rejections(rendered(deep_scene()), expected), std::vector<std::string>{})
      << "it changes the picture";
}

TEST(FullScene, HighlightOfLabelsMatchesAnIndependentEstimator) {
  diaphane::v1::Scene scene = deep_scene();
  add_looks(scene);
  add_highlight(scene);
  EXPECT_EQ(rejections(rendered(scene), reference(scene)), std::vector<std::string>{});
}

const Tiles& deep_reference() {
  static const Tiles known = reference(deep_scene());
  return known;
}

TEST(FullScene, DeepPathsMatchAnIndependentEstimator) {
  EXPECT_EQ(rejections(rendered(deep_scene()), deep_reference()), std::vector<std::string>{});
}

TEST(FullScene, SurfacesMatchAnIndependentEstimator) {
  diaphane::v1::Scene scene = deep_scene();
  scene.mutable_shading()->set_mode(diaphane::v1::Shading::SURFACE);
  scene.set_bounces(2);
  EXPECT_EQ(rejections(rendered(scene), reference(scene)), std::vector<std::string>{});
}

TEST(FullScene, TestDetectsMissingCollisions) {
  diaphane::v1::Scene scene = deep_scene();
  scene.set_bounces(2);
  EXPECT_NE(rejections(rendered(scene), deep_reference()), std::vector<std::string>{});
}

TEST(FullScene, TestDetectsASmallBias) {
  // Matter reflects this much more than in the reference. A quarter of the pictures detects twice
  // the bias.
  const double more = test::gate_or_nightly(1.06, 1.03);
  diaphane::v1::Scene scene = full_scene(0.5);
  for (auto& channel : *scene.mutable_transfer_function()->mutable_channels()) {
    auto* c = channel.mutable_diffuse();
    test::set(c, more * c->r() <= 1 ? more * c->r() : c->r(), more * c->g(), more * c->b());
  }
  EXPECT_NE(rejections(rendered(scene), reference_of(0.5)), std::vector<std::string>{});
}

}  // namespace
}  // namespace diaphane::render
