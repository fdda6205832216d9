// Clip box and free planes. The geometry is compared with double precision in world space, pictures
// are compared with those of a cropped volume, and both ways to treat light with their exact
// integrals.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "renderd/kernel/estimator.h"
#include "tests/support/renderd/optics.h"
#include "tests/support/renderd/test_statistics.h"

namespace diaphane::render {
namespace {

constexpr double kAlpha = 1e-3;
constexpr Features kClip = Features{}.with(Feature::kClip);
constexpr Features kClipLight = kClip.with(Feature::kClipLight);

TEST(Clip, ClipsRayToBoxAndPlanes) {
  diaphane::v1::Scene scene = test::skull_scene();
  test::set(scene.mutable_clip()->mutable_box_low(), -12, -14, -9);
  test::set(scene.mutable_clip()->mutable_box_high(), 15, 11, 13);
  const double planes[2][6] = {{3, 1, 2, 0.3, -0.5, 0.8}, {-2, 4, 0, -4, 1, 0.7}};
  for (const auto& n : planes) {
    auto* plane = scene.mutable_clip()->add_planes();
    test::set(plane->mutable_point(), n[0], n[1], n[2]);
    test::set(plane->mutable_normal(), n[3], n[4], n[5]);
  }
  const test::Prepared p(test::tilt(test::constant_volume(30, 7, 1.5)), scene);
  EXPECT_EQ(p.scene().features.has(Feature::kClipLight), false);
  const auto kept = [&](Double3 w) {
    if (!(w.x >= -12 && w.y >= -14 && w.z >= -9 && w.x <= 15 && w.y <= 11 && w.z <= 13)) {
      return false;
    }
    for (const auto& n : planes) {
      if (dot(w - Double3{n[0], n[1], n[2]}, Double3{n[3], n[4], n[5]}) > 0) return false;
    }
    return true;
  };
  Random random(21, 0, 0);
  const auto number = [&] { return random.one() * 60 - 15; };
  int crossed = 0;
  for (int i = 0; i < 20000; ++i) {
    const Float3 from{number(), number(), number()}, to{number(), number(), number()};
    const Ray ray{from, normalize(to - from) * (1 / 1.5f)};
    const Span span = clip_span<kClip>(p.view(), ray, Span{0, 200}, RayKind::kCamera);
    const auto inside = [&](float t) {
      return kept(test::to_world(p.volume().header, to_double(ray.at(t))));
    };
    constexpr float kNear = 1e-2f;  // mm
    if (span.begin + 2 * kNear < span.end) {
      ++crossed;
      EXPECT_TRUE(inside(span.begin + kNear) && inside(span.end - kNear));
      EXPECT_TRUE(inside(0.5f * (span.begin + span.end)));
      EXPECT_FALSE(inside(span.end + kNear));
      if (span.begin > 0) {
        EXPECT_FALSE(inside(span.begin - kNear));
      }
    } else {
      for (int k = 0; k < 40; ++k) EXPECT_FALSE(inside(2 * kNear + static_cast<float>(k) * 1.3f));
    }
    const Span light = clip_span<kClip>(p.view(), ray, Span{0, 200}, RayKind::kLight);
    EXPECT_TRUE(light.begin == 0 && light.end == 200);
  }
  EXPECT_GT(crossed, 2000);
}

TEST(Clip, IneffectiveClipIsCompiledOut) {
  diaphane::v1::Scene scene = test::skull_scene();
  const auto features = [&] {
    return test::Prepared(test::constant_volume(10, 7), scene).scene().features;
  };
  test::set(scene.mutable_clip()->mutable_box_low(), -5, -5, -5);
  test::set(scene.mutable_clip()->mutable_box_high(), 5, 5, 5);
  scene.mutable_clip()->set_cuts_light(true);
  EXPECT_FALSE(features().has(Feature::kClip));
  EXPECT_FALSE(features().has(Feature::kClipLight));
  scene.mutable_clip()->mutable_box_high()->set_z(4.9);
  EXPECT_TRUE(features().has(Feature::kClip));
  EXPECT_TRUE(features().has(Feature::kClipLight));
  scene.mutable_clip()->set_cuts_light(false);
  EXPECT_FALSE(features().has(Feature::kClipLight));
}

TEST(Clip, BoxWithoutThicknessShowsNothing) {
  diaphane::v1::Scene scene = test::skull_scene();
  test::set(scene.mutable_clip()->mutable_box_low(), -5, 0, -5);
  test::set(scene.mutable_clip()->mutable_box_high(), 5, 0, 5);
  scene.mutable_display()->set_show_environment(false);
  const test::Prepared p(test::skull_volume(), scene);
  for (std::uint64_t i = 0; i < 10; ++i) {
    for (std::uint32_t y = 0; y < 16; ++y) {
      for (std::uint32_t x = 0; x < 16; ++x) {
        EXPECT_EQ(estimate<kAllFeatures>(p.view(), x, y, i).radiance.x, 0);
      }
    }
  }
}

/// Blocks of 4 voxels of one value each. A cut through the middle of blocks does not change how the
/// remaining voxels are interpolated.
double block(double x, double y, double z) {
  const int i = static_cast<int>(x / 4), j = static_cast<int>(y / 4), k = static_cast<int>(z / 4);
  return (i * 7 + j * 5 + k * 3) % 4 * 250;
}

diaphane::v1::Scene block_scene(double x, double y, double z) {
  diaphane::v1::Scene scene;
  test::add_channel(*scene.mutable_transfer_function(), {{100, 0}, {800, 1}}, 0.9, 0.6, 0.3);
  scene.mutable_transfer_function()->set_extinction_per_mm(0.4);
  test::add_lamp(scene, 8 + x, -6 + y, 45 + z, 20, 20);
  test::add_sky(scene, 0.5);
  test::set(scene.mutable_camera()->mutable_eye(), 30 + x, -45 + y, 25 + z);
  test::set(scene.mutable_camera()->mutable_target(), x, y, z);
  test::set(scene.mutable_camera()->mutable_up(), 0, 0, 1);
  scene.mutable_camera()->set_vertical_fov_degrees(30);
  return scene;
}

/// Returns the moments of tiles of 4 x 4 pixels. One observation is the sum over a tile of one
/// picture of 8 samples per pixel.
template <Features F>
std::vector<test::Moments> tiles_of(const test::Prepared& p, std::uint64_t seed) {
  constexpr std::uint32_t kSide = 16, kTile = 4, kPictures = 150, kSamples = 8;
  std::vector<test::Moments> tiles(kSide / kTile * (kSide / kTile));
  for (std::uint64_t picture = 0; picture < kPictures; ++picture) {
    const auto view = p.view(seed + picture);
    std::vector<double> sums(tiles.size());
    for (std::uint32_t y = 0; y < kSide; ++y) {
      for (std::uint32_t x = 0; x < kSide; ++x) {
        for (std::uint32_t i = 0; i < kSamples; ++i) {
          const Float3 c = estimate<F>(view, x, y, i).radiance;
          sums[x / kTile + kSide / kTile * (y / kTile)] += static_cast<double>(c.x + c.y + c.z);
        }
      }
    }
    for (std::size_t i = 0; i < tiles.size(); ++i) tiles[i].add(sums[i]);
  }
  return tiles;
}

double largest_t(const std::vector<test::Moments>& a, const std::vector<test::Moments>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max(most, std::abs(test::welch(a[i], b[i])));
  return most;
}

/// Welch's t of each tile, with a significance of 1e-3 over all tiles and both kernels (Sidak).
TEST(Clip, BoxThatCutsLightEqualsACroppedVolume) {
  constexpr Features kLit = kClipLight.with(Feature::kAreaLights).with(Feature::kEnvironment);
  // The box keeps the voxels [6, 18) x [2, 22) x [6, 14) of 24 x 24 x 20 voxels of 1 x 1.2 x 1.5
  // mm.
  diaphane::v1::Scene scene = block_scene(0, 0, 0);
  test::set(scene.mutable_clip()->mutable_box_low(), -6, -12, -6);
  test::set(scene.mutable_clip()->mutable_box_high(), 6, 12, 6);
  scene.mutable_clip()->set_cuts_light(true);
  const test::Prepared clipped(test::make_volume({24, 24, 20}, {1, 1.2, 1.5}, block), scene);
  ASSERT_EQ(clipped.scene().features.without(Feature::kCurves), kLit);
  const test::Prepared cropped(
      test::make_volume({12, 20, 8}, {1, 1.2, 1.5},
                        [](double x, double y, double z) { return block(x + 6, y + 2, z + 6); }),
      block_scene(0, 0, 0));
  const auto truth =
      tiles_of<kLit.without(Feature::kClip).without(Feature::kClipLight)>(cropped, 1);
  const double limit = test::critical_t(test::sidak(kAlpha, 2 * truth.size()), 149);
  EXPECT_LT(largest_t(tiles_of<kLit>(clipped, 1000), truth), limit);
  EXPECT_LT(largest_t(tiles_of<kAllFeatures>(clipped, 2000), truth), limit);
  scene.mutable_clip()->set_cuts_light(false);
  const test::Prepared shadowed(clipped.volume(), scene);
  EXPECT_GT(largest_t(tiles_of<kAllFeatures>(shadowed, 3000), truth), limit)
      << "the clipped part casts a shadow";
}

/// A homogeneous cube of 20 mm is cut in the middle across the view axis. A lamp behind the camera
/// shines through the part that is cut away. Single scattering is an integral over the ray and the
/// lamp.
TEST(Clip, ClippedRegionCastsShadowsOnlyIfConfigured) {
  constexpr double kExtinction = 0.15;
  const double limit = test::critical_z(test::sidak(kAlpha, 3));
  double previous = 0;
  for (const bool cuts_light : {false, true}) {
    diaphane::v1::Scene scene;
    test::add_channel(*scene.mutable_transfer_function(), {{0, 1}, {2000, 1}}, 1, 1, 1);
    scene.mutable_transfer_function()->set_extinction_per_mm(kExtinction);
    auto* lamp = scene.add_lights()->mutable_rectangle();  // shines along +y
    test::set(lamp->mutable_corner(), 2, -40, -8);
    test::set(lamp->mutable_u(), 0, 0, 16);
    test::set(lamp->mutable_v(), 16, 0, 0);
    test::set(lamp->mutable_radiance(), 7, 7, 7);
    test::set_camera(scene, 0, -500, 0, 0.002);
    auto* plane = scene.mutable_clip()->add_planes();
    test::set(plane->mutable_normal(), 0, -1, 0);
    scene.mutable_clip()->set_cuts_light(cuts_light);
    const test::Prepared p(test::constant_volume(10, 1000, 2), scene, {1, 1});
    const auto mean_of = [&](auto kernel) {
      test::Moments m;
      for (std::uint64_t i = 0; i < 300'000; ++i) m.add(static_cast<double>(kernel(i)));
      return m;
    };
    const auto view = p.view();
    const test::Moments mean = mean_of([&](std::uint64_t i) {
      return cuts_light ? estimate<kClipLight.with(Feature::kAreaLights)>(view, 0, 0, i).radiance.x
                        : estimate<kClip.with(Feature::kAreaLights)>(view, 0, 0, i).radiance.x;
    });
    const test::Moments general = mean_of(
        [&](std::uint64_t i) { return estimate<kAllFeatures>(p.view(9), 0, 0, i).radiance.x; });
    double exact = 0;
    constexpr int kSteps = 200, kSide = 60;
    for (int i = 0; i < kSteps; ++i) {
      const double depth = 10 * (i + 0.5) / kSteps;  // below the cut, which is at y = 0
      for (int a = 0; a < kSide; ++a) {
        for (int b = 0; b < kSide; ++b) {
          const Double3 to = Double3{2 + 16 * (a + 0.5) / kSide, -40, -8 + 16 * (b + 0.5) / kSide} -
                             Double3{0, depth, 0};
          const double distance = length(to);
          const Double3 w = to * (1 / distance);
          // A ray ends at the side y = 0 or y = -10; the lamp's position ensures that no ray leaves
          // elsewhere.
          const double way = (cuts_light ? depth : depth + 10) / -w.y;
          exact += std::exp(-kExtinction * (depth + way)) * -w.y / (distance * distance);
        }
      }
    }
    exact *= 7 * kExtinction * (10.0 / kSteps) * (16.0 * 16.0 / (kSide * kSide)) /
             (4 * std::numbers::pi);
    EXPECT_NEAR(mean.mean, exact, limit * mean.error_of_mean() + 1e-3 * exact) << cuts_light;
    EXPECT_NEAR(general.mean, exact, limit * general.error_of_mean() + 1e-3 * exact) << cuts_light;
    EXPECT_GT(mean.mean, 2 * previous) << "both modes differ by at least exp(-1.5)";
    previous = mean.mean;
  }
}

/// An oblique plane through a tilted, homogeneous, black cube before a white background. The
/// picture shows the transmittance of the remaining part, according to Beer and Lambert. The test
/// is binomial, with a significance of 1e-3 over the pixels.
TEST(Clip, PlaneClipsTheTransmittanceOfTheRay) {
  diaphane::v1::Scene scene;
  test::add_channel(*scene.mutable_transfer_function(), {{0, 1}, {2000, 1}}, 0, 0, 0);
  scene.mutable_transfer_function()->set_extinction_per_mm(0.1);
  test::set_camera(scene, 30, -60, 20, 20);
  test::set(scene.mutable_display()->mutable_background(), 1, 1, 1);
  const Double3 point{1, 2, 3}, normal{0.2, -0.9, 0.5};
  auto* plane = scene.mutable_clip()->add_planes();
  test::set(plane->mutable_point(), point.x, point.y, point.z);
  test::set(plane->mutable_normal(), normal.x, normal.y, normal.z);
  const test::Prepared p(test::tilt(test::constant_volume(10, 1000, 2)), scene, {8, 8});
  ASSERT_EQ(p.scene().features, kClip);
  auto view = p.view();
  const auto& header = p.volume().header;
  constexpr int kSamples = 20'000, kSteps = 4000;
  const double limit = test::critical_z(test::sidak(kAlpha, 64));
  for (std::uint32_t y = 0; y < 8; ++y) {
    for (std::uint32_t x = 0; x < 8; ++x) {
      // One ray per pixel, through its centre.
      const CameraRay r =
          camera_ray<kClip>(view, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
      double way = 0;
      for (int i = 0; i < kSteps; ++i) {
        const double t = 120 * (i + 0.5) / kSteps;
        const Double3 index = to_double(r.ray.origin) + to_double(r.ray.direction) * t;
        bool inside = dot(test::to_world(header, index) - point, normal) <= 0;
        for (int axis = 0; axis < 3; ++axis) inside &= index[axis] >= 0 && index[axis] <= 10;
        way += inside ? 120.0 / kSteps : 0;
      }
      int through = 0;
      for (int i = 0; i < kSamples; ++i) {
        Random random(5, x + 8 * y, static_cast<std::uint64_t>(i));
        const PrimaryHit primary = primary_hit<kClip>(view, r, {});
        through += !(primary.span.begin < primary.span.end) ||
                           !track(r.ray, primary.span, view.grid,
                                  Medium<LinearVolume>{view.volume, view.transfer}, random)
                                .found
                       ? 1
                       : 0;
      }
      const double exact = std::exp(-0.1 * way);
      EXPECT_NEAR(through / double{kSamples}, exact,
                  limit * std::sqrt(exact * (1 - exact) / kSamples) + 0.1 * 120.0 / kSteps);
    }
  }
}

}  // namespace
}  // namespace diaphane::render
