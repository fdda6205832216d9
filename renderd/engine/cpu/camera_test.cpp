// Compares the thin lens and parallel rays with their formulas in world space and double precision.
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
constexpr Features kLens = Features{}.with(Feature::kLens);
constexpr Features kParallel = Features{}.with(Feature::kOrthographic);

volume::Volume tilted_volume() {
  return test::tilt(test::make_volume({40, 30, 20}, {1, 1.5, 2}, [](double x, double y, double z) {
    return 100 * std::sin(x) * std::cos(y) + z;
  }));
}

/// Returns the point where a ray meets the plane at `depth` mm from the eye along the view axis, in
/// world space.
Double3 at_depth(const test::WorldCamera& camera, const volume::Header& header, const Ray& ray,
                 double depth) {
  const Double3 a = test::to_world(header, to_double(ray.origin));
  const Double3 b = test::to_world(header, to_double(ray.at(1)));
  const Double3 d = b - a;
  const double t = (depth - dot(a - camera.eye, camera.forward)) / dot(d, camera.forward);
  return a + d * t;
}

/// At any distance of the camera, all rays of one point of the picture meet in the plane of focus,
/// at the point of the pinhole's ray. At another depth they fill the circle of confusion, whose
/// radius is aperture |1 - depth / focus|.
template <Features F>
void expect_thin_lens(double distance, bool parallel) {
  diaphane::v1::Scene scene = test::skull_scene();
  const double height = 50;
  const Double3 from = normalize(Double3{0.6, -0.7, 0.3}) * distance;
  test::set_camera(scene, from.x, from.y, from.z,
                   2 * std::atan(height / 2 / distance) * 180 / std::numbers::pi);
  if (parallel) scene.mutable_camera()->set_orthographic_height(height);
  const double aperture = distance / 20, focus = distance - 8;
  scene.mutable_camera()->set_aperture_radius(aperture);
  scene.mutable_camera()->set_focal_distance(focus);
  const test::Prepared p(tilted_volume(), scene, {64, 48});
  const auto view = p.view();
  const test::WorldCamera camera(scene.camera());
  const double tangent = std::tan(scene.camera().vertical_fov_degrees() * std::numbers::pi / 360);
  Random random(3, 0, 0);
  double widest = 0;
  for (int i = 0; i < 2000; ++i) {
    const double x = 4.0 * (i % 16) + 1, y = 3.0 * (i / 16 % 16) + 1;
    const double a = (2 * x / 64 - 1) * 64 / 48, b = 1 - 2 * y / 48;
    const auto middle = [&](double depth) {
      const double half = parallel ? height / 2 : tangent * depth;
      return camera.eye + camera.forward * depth + (camera.right * a + camera.up * b) * half;
    };
    const CameraRay r =
        camera_ray<F>(view, static_cast<float>(x), static_cast<float>(y), random.two());
    EXPECT_LT(length(at_depth(camera, p.volume().header, r.ray, focus) - middle(focus)), 2e-3);
    const double depth = distance + 15;
    const double blur = length(at_depth(camera, p.volume().header, r.ray, depth) - middle(depth));
    const double radius = aperture * std::abs(1 - depth / focus);
    EXPECT_LT(blur, radius + 2e-3);
    widest = std::max(widest, blur / radius);
    EXPECT_LT(length(r.ray.origin - Float3{20, 15, 10}), 200.0f) << "begins near the box";
    EXPECT_NEAR(length(r.direction), 1, 1e-6);
  }
  EXPECT_GT(widest, 0.995) << "the lens is used to its edge";
}

TEST(Lens, RaysMeetInTheFocalPlaneAndFillTheCircleOfConfusion) {
  for (const double distance : {100.0, 1e4, 1e6}) {
    expect_thin_lens<kLens>(distance, false);
    expect_thin_lens<kLens.with(Feature::kOrthographic)>(distance, false);
    expect_thin_lens<kLens.with(Feature::kOrthographic)>(distance, true);
  }
}

TEST(Lens, FocusesOnTheTargetWithoutFocalDistance) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.mutable_camera()->set_aperture_radius(8);
  const test::Prepared p(tilted_volume(), scene, {64, 48});
  Random random(5, 0, 0);
  for (int i = 0; i < 100; ++i) {
    const CameraRay r = camera_ray<kLens>(p.view(), 32, 24, random.two());
    const Float3 middle{20, 15, 10};
    const float along =
        dot(middle - r.ray.origin, r.ray.direction) / dot(r.ray.direction, r.ray.direction);
    const Double3 off = test::to_world(p.volume().header, to_double(r.ray.at(along)));
    EXPECT_LT(length(off), 0.02) << "in voxels the nearest place is not quite the plane's";
  }
}

/// The picture shows one bright voxel in a slice across the view axis. A blur by a disk of radius R
/// adds R^2 / 2 to the mean square radius, whatever that is without the blur, except for the size
/// of pixels, 0.3 mm. One picture of 32 samples per pixel is one observation, and there are 40 of
/// them. The significance is 1e-3.
test::Moments squared_radius(double focus) {
  volume::Volume v = test::make_volume({41, 3, 41}, {1, 1, 1}, [](double x, double y, double z) {
    return x == 20.5 && y == 1.5 && z == 20.5 ? 1000 : 0;
  });
  diaphane::v1::Scene scene = test::skull_scene();
  test::set_camera(scene, 0, -100, 0, 2 * std::atan(0.07) * 180 / std::numbers::pi);
  scene.mutable_camera()->set_aperture_radius(6);
  scene.mutable_camera()->set_focal_distance(focus);
  test::show(scene.mutable_slices()->mutable_coronal(), 0);
  scene.mutable_slices()->set_alone(true);
  scene.mutable_slices()->set_window_centre(500);
  scene.mutable_slices()->set_window_width(1000);
  scene.mutable_display()->set_show_environment(false);
  constexpr std::uint32_t kSide = 48, kSamples = 32;
  const test::Prepared p(std::move(v), scene, {kSide, kSide});
  test::Moments out;
  for (std::uint64_t picture = 0; picture < 40; ++picture) {
    const auto view = p.view(picture + 1);
    double sum = 0, squares = 0;
    for (std::uint32_t y = 0; y < kSide; ++y) {
      for (std::uint32_t x = 0; x < kSide; ++x) {
        const double mm = 14.0 / kSide;
        const double dx = (x + 0.5) * mm - 7, dy = (y + 0.5) * mm - 7;
        for (std::uint32_t i = 0; i < kSamples; ++i) {
          const double light =
              static_cast<double>(estimate<kLens.with(Feature::kSlices)>(view, x, y, i).radiance.x);
          sum += light;
          squares += light * (dx * dx + dy * dy);
        }
      }
    }
    out.add(squares / sum);
  }
  return out;
}

TEST(Lens, BlursPointToTheCircleOfConfusion) {
  const test::Moments sharp = squared_radius(100);
  EXPECT_LT(sharp.mean, 1.0) << "in the plane of focus a voxel stays a voxel (mm^2)";
  const double limit = test::critical_z(test::sidak(kAlpha, 2));
  for (const double focus : {60.0, 180.0}) {
    const test::Moments blurred = squared_radius(focus);
    const double radius = 6 * std::abs(1 - 100 / focus);
    const double error = std::hypot(blurred.error_of_mean(), sharp.error_of_mean());
    EXPECT_NEAR(blurred.mean - sharp.mean, radius * radius / 2, limit * error + 0.01) << focus;
    EXPECT_LT(error, 0.01 * radius * radius / 2) << "the test detects 4%";
  }
}

/// A black, opaque cube of 20 mm before a white background. Parallel rays show it at the same size
/// from any distance: 20 mm of `orthographic_height`. With independent points, one sample of each
/// pixel is a Bernoulli trial. The significance is 1e-3.
TEST(Orthographic, ImageHeightDoesNotDependOnTheDistance) {
  const double limit = test::critical_z(test::sidak(kAlpha, 3));
  for (const double distance : {30.0, 500.0, 1e6}) {
    diaphane::v1::Scene scene;
    test::add_channel(*scene.mutable_transfer_function(), {{0, 1}, {2000, 1}}, 0, 0, 0);
    scene.mutable_transfer_function()->set_extinction_per_mm(1e4);
    test::set_camera(scene, 0, -distance, 0, 0);
    scene.mutable_camera()->set_orthographic_height(50);
    test::set(scene.mutable_display()->mutable_background(), 1, 1, 1);
    const test::Prepared p(test::constant_volume(10, 1000, 2), scene, {80, 50});
    ASSERT_EQ(p.scene().features, kParallel);
    const auto view = p.view();
    double dark = 0, all = 0;
    for (std::uint64_t i = 0; i < 16; ++i) {
      for (std::uint32_t y = 0; y < 50; ++y) {
        for (std::uint32_t x = 0; x < 80; ++x) {
          dark += estimate<kParallel>(view, x, y, i).radiance.x == 0 ? 1 : 0;
          all += 1;
        }
      }
    }
    const double share = 20.0 * 20.0 / (50.0 * 80.0);
    EXPECT_NEAR(dark / all, share, limit * std::sqrt(share * (1 - share) / all)) << distance;
  }
}

TEST(Orthographic, RaysAreParallelAndStartNearTheBox) {
  diaphane::v1::Scene scene = test::skull_scene();
  test::set_camera(scene, 6e5, -7e5, 3e5, 0);
  scene.mutable_camera()->set_orthographic_height(80);
  const test::Prepared p(tilted_volume(), scene, {64, 48});
  const test::WorldCamera camera(scene.camera());
  const Float3 first = camera_ray<kParallel>(p.view(), 0, 0).direction;
  for (const auto& [x, y] :
       {std::pair{0.0f, 48.0f}, {64.0f, 0.0f}, {32.0f, 24.0f}, {50.0f, 7.0f}}) {
    const CameraRay r = camera_ray<kParallel>(p.view(), x, y);
    EXPECT_EQ(length(r.direction - first), 0);
    const Double3 at = at_depth(camera, p.volume().header, r.ray, length(camera.eye));
    const double a = static_cast<double>(2 * x / 64 - 1) * 64 / 48,
                 b = 1 - 2 * static_cast<double>(y) / 48;
    EXPECT_LT(length(at - (camera.right * a + camera.up * b) * 40.0), 2e-3);
  }
}

TEST(Camera, TheBackgroundChangesTowardsThePicturesCorners) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.mutable_display()->set_show_environment(false);
  scene.mutable_display()->mutable_background()->set_r(0.5);
  scene.mutable_display()->mutable_background_edge()->set_r(0.1);
  const auto red_at = [&](float x, float y) {
    const test::Prepared p(test::constant_volume(8, -1000), scene, {64, 48});
    return primary_hit<Features{}>(p.view(), camera_ray<Features{}>(p.view(), x, y), {})
        .background.x;
  };
  EXPECT_FLOAT_EQ(red_at(32, 24), 0.5f);
  EXPECT_FLOAT_EQ(red_at(0, 48), 0.1f);
  EXPECT_FLOAT_EQ(red_at(64, 24), 0.3f);
  scene.mutable_display()->clear_background_edge();
  EXPECT_FLOAT_EQ(red_at(0, 48), 0.5f);
}

/// A kernel that supports a lens and parallel rays gives the same picture for a scene with neither.
TEST(Camera, GeneralKernelGeneratesTheSameRays) {
  const test::Prepared p(tilted_volume(), test::skull_scene(), {64, 48});
  Random random(11, 0, 0);
  for (int i = 0; i < 200; ++i) {
    const Random::Pair at = random.two(), lens = random.two();
    const CameraRay lean = camera_ray<Features{}>(p.view(), 64 * at.a, 48 * at.b);
    const CameraRay full = camera_ray<kAllFeatures>(p.view(), 64 * at.a, 48 * at.b, lens);
    EXPECT_EQ(length(lean.direction - full.direction), 0);
    EXPECT_EQ(length(lean.ray.origin - full.ray.origin), 0);
  }
}

}  // namespace
}  // namespace diaphane::render
