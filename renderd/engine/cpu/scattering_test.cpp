#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "renderd/kernel/estimator.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

// The furnace of single scattering. In a uniform environment of radiance L, a medium of albedo a
// cannot return L, because light that is scattered twice is missing. The radiance is known exactly:
//
//   R = a L integral of extinction(s) T(camera..s) V(s) ds,   V(s) = sum over directions of phase
//   times transmittance
//
// For a homogeneous cube, this is an integral of exponentials of path lengths. The tests compute it
// by quadrature in double precision.

namespace diaphane::render {
namespace {

constexpr double kAlpha = 1e-3;
constexpr double kEdge = 20;  // mm
const std::uint64_t kSamples = test::gate_or_nightly(60'000, 400'000);

/// Returns the distance in mm from `p` inside the cube [0, kEdge]^3 to its surface along the unit
/// vector `d`.
double to_surface(Double3 p, Double3 d) {
  double least = 1e9;
  const double ps[] = {p.x, p.y, p.z}, ds[] = {d.x, d.y, d.z};
  for (int axis = 0; axis < 3; ++axis) {
    if (ds[axis] > 1e-12) least = std::min(least, (kEdge - ps[axis]) / ds[axis]);
    if (ds[axis] < -1e-12) least = std::min(least, -ps[axis] / ds[axis]);
  }
  return least;
}

double henyey_greenstein_exact(double g, double cosine) {
  const double d = 1 + g * g - 2 * g * cosine;
  return (1 - g * g) / (4 * std::numbers::pi * d * std::sqrt(d));
}

/// Returns the radiance above for albedo 1 and L = 1 along a ray that enters the cube at `entry`
/// with direction `d`. It uses a Fibonacci sphere of directions, and the midpoint rule in the
/// transmittance along the ray.
double furnace(Double3 entry, Double3 d, double extinction, double g) {
  constexpr int kSteps = 400, kDirections = 4000;
  const double way = to_surface(entry + d * 1e-9, d);
  const double share = -std::expm1(-extinction * way);  // share of the light that collides
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double s = -std::log1p(-share * (i + 0.5) / kSteps) / extinction;
    const Double3 p = entry + d * s;
    double visible = 0;
    for (int k = 0; k < kDirections; ++k) {
      const double z = 1 - (2 * k + 1.0) / kDirections;
      const double angle = k * std::numbers::pi * (3 - std::sqrt(5.0));
      const double r = std::sqrt(1 - z * z);
      const Double3 w{r * std::cos(angle), r * std::sin(angle), z};
      visible += henyey_greenstein_exact(g, dot(d, w)) * std::exp(-extinction * to_surface(p, w));
    }
    sum += visible * 4 * std::numbers::pi / kDirections;
  }
  return sum / kSteps * share;
}

/// A cube of 20 mm of one value in a sky of radiance 2. The camera is far away along -y and has one
/// pixel, whose field of view is so narrow that all rays are the same.
test::Prepared cube(double extinction, double albedo, double g) {
  diaphane::v1::Scene scene;
  test::add_channel(*scene.mutable_transfer_function(), {{0, 1}, {2000, 1}}, albedo, albedo / 2, 0);
  scene.mutable_transfer_function()->set_extinction_per_mm(extinction);
  test::add_sky(scene, 2);
  test::set_camera(scene, 0, -500, 0, 0.002);
  scene.mutable_phase()->set_g(g);
  return test::Prepared(test::constant_volume(10, 1000, 2), scene, {1, 1});
}

TEST(Furnace, SingleScatteringInAUniformSkyMatchesTheIntegral) {
  struct Setting {
    double extinction, albedo, g;
  };
  const Setting settings[] = {{0.001, 1, 0}, {0.05, 1, 0},    {0.5, 0.7, 0},
                              {20, 1, 0},    {0.1, 0.9, 0.6}, {0.1, 1, -0.5}};
  const double limit = test::critical_z(test::sidak(kAlpha, std::size(settings)));
  for (const Setting& s : settings) {
    const test::Prepared p = cube(s.extinction, s.albedo, s.g);
    const auto view = p.view();
    test::Moments red, green;
    for (std::uint64_t i = 0; i < kSamples; ++i) {
      const Sample sample =
          s.g == 0
              ? estimate<Features{}.with(Feature::kEnvironment)>(view, 0, 0, i)
              : estimate<Features{}.with(Feature::kEnvironment).with(Feature::kAnisotropicPhase)>(
                    view, 0, 0, i);
      red.add(sample.radiance.x);
      green.add(sample.radiance.y);
      ASSERT_EQ(sample.radiance.z, 0);
      ASSERT_LE(sample.radiance.x, 2 * s.albedo * 1.0001) << "no more than the sky gives";
    }
    const double exact = 2 * s.albedo * furnace({10, 0, 10}, {0, 1, 0}, s.extinction, s.g);
    EXPECT_NEAR(red.mean, exact, limit * red.error_of_mean() + 2e-3 * exact)
        << "extinction " << s.extinction << ", g " << s.g;
    EXPECT_NEAR(green.mean, red.mean / 2, 1e-5);
  }
}

/// The same cube is lit by a lamp, and the quadrature is over the area of the lamp instead of the
/// sphere.
TEST(Lamp, SingleScatteringMatchesTheIntegral) {
  for (const double g : {0.0, 0.7}) {
    diaphane::v1::Scene scene;
    test::add_channel(*scene.mutable_transfer_function(), {{0, 1}, {2000, 1}}, 1, 1, 1);
    scene.mutable_transfer_function()->set_extinction_per_mm(0.1);
    test::add_lamp(scene, 5, 3, 30, 16, 7);
    test::set_camera(scene, 0, -500, 0, 0.002);
    scene.mutable_phase()->set_g(g);
    const test::Prepared p(test::constant_volume(10, 1000, 2), scene, {1, 1});
    const auto view = p.view();
    test::Moments moments;
    for (std::uint64_t i = 0; i < kSamples; ++i) {
      moments.add(
          g == 0 ? estimate<Features{}.with(Feature::kAreaLights)>(view, 0, 0, i).radiance.x
                 : estimate<Features{}.with(Feature::kAreaLights).with(Feature::kAnisotropicPhase)>(
                       view, 0, 0, i)
                       .radiance.x);
    }
    double exact = 0;
    constexpr int kSteps = 400, kSide = 60;
    for (int i = 0; i < kSteps; ++i) {
      const Double3 q{10, kEdge * (i + 0.5) / kSteps, 10};
      for (int a = 0; a < kSide; ++a) {
        for (int b = 0; b < kSide; ++b) {
          // In the frame of the volume, the corner of the box is the origin and its centre is (10,
          // 10, 10).
          const Double3 lamp{15 - 8 + 16 * (a + 0.5) / kSide, 13 - 8 + 16 * (b + 0.5) / kSide, 40};
          const Double3 to = lamp - q;
          const double distance = length(to);
          const Double3 w = to * (1 / distance);
          exact += std::exp(-0.1 * (q.y + to_surface(q, w))) * henyey_greenstein_exact(g, w.y) *
                   w.z / (distance * distance);
        }
      }
    }
    exact *= 7 * 0.1 * (kEdge / kSteps) * (16.0 * 16.0 / (kSide * kSide));
    EXPECT_NEAR(moments.mean, exact,
                test::critical_z(kAlpha / 2) * moments.error_of_mean() + 1e-3 * exact)
        << "g " << g;
  }
}

/// Returns the mean for the variant `F`. A variant with more features than a scene needs must have
/// the same mean as the exact one.
template <Features F>
test::Moments mean_with(const SceneView<LinearVolume>& view) {
  test::Moments m;
  for (std::uint64_t i = 0; i < test::gate_or_nightly(16u, 100u); ++i) {
    for (std::uint32_t y = 0; y < view.height; ++y) {
      for (std::uint32_t x = 0; x < view.width; ++x) {
        const Float3 c = estimate<F>(view, x, y, i).radiance;
        m.add(c.x + c.y + c.z);
      }
    }
  }
  return m;
}

TEST(Variants, ExtraFeaturesGiveTheSameEstimate) {
  constexpr Features kLean = Features{}.with(Feature::kAreaLights).with(Feature::kEnvironment);
  const test::Prepared p(test::skull_volume(), test::skull_scene(), {48, 48});
  ASSERT_EQ(p.scene().features, kLean);
  const test::Moments lean = mean_with<kLean>(p.view(1));
  const double limit = test::critical_z(test::sidak(kAlpha, 3));
  EXPECT_LT(std::abs(test::welch(lean, mean_with<kAllFeatures>(p.view(2)))), limit);
  EXPECT_LT(std::abs(test::welch(lean, mean_with<kLean.with(Feature::kManyLights)>(p.view(3)))),
            limit);
  EXPECT_LT(
      std::abs(test::welch(lean, mean_with<kLean.with(Feature::kAnisotropicPhase)>(p.view(4)))),
      limit);
}

/// Tests a medium that is deep enough for crossing macrocells voxel by voxel, with and without this
/// method.
TEST(Variants, PerVoxelBoundsKeepTheEstimate) {
  constexpr Features kPlain = Features{}.with(Feature::kAreaLights).with(Feature::kEnvironment);
  constexpr Features kSteep = kPlain.with(Feature::kSteepExtinction);
  diaphane::v1::Scene scene = test::skull_scene();
  scene.mutable_transfer_function()->set_extinction_per_mm(12);
  const test::Prepared p(test::skull_volume(), scene, {48, 48});
  ASSERT_EQ(p.scene().features, kSteep);
  EXPECT_LT(std::abs(test::welch(mean_with<kPlain>(p.view(1)), mean_with<kSteep>(p.view(2)))),
            test::critical_z(kAlpha));
}

/// With two lamps picked by power, the result is the sum of the results of each alone.
TEST(Lamps, PickingOneLampGivesTheSumOfBoth) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.clear_lights();
  scene.mutable_display()->set_show_environment(false);
  diaphane::v1::Scene one = scene, two = scene, both = scene;
  test::add_lamp(one, -20, 15, 70, 40, 30);
  test::add_lamp(two, 50, 0, 40, 10, 100);
  *both.add_lights() = one.lights(0);
  *both.add_lights() = two.lights(0);
  static constexpr Features kOne = Features{}.with(Feature::kAreaLights);
  const auto mean = [](const diaphane::v1::Scene& s, std::uint64_t seed) {
    const test::Prepared p(test::skull_volume(), s, {48, 48});
    return p.scene().lights.size() > 1 ? mean_with<kOne.with(Feature::kManyLights)>(p.view(seed))
                                       : mean_with<kOne>(p.view(seed));
  };
  const test::Moments a = mean(one, 1), b = mean(two, 2), ab = mean(both, 3);
  const double error = std::sqrt(a.variance() / a.n + b.variance() / b.n + ab.variance() / ab.n);
  EXPECT_NEAR(ab.mean, a.mean + b.mean, test::critical_z(kAlpha) * error);
}

}  // namespace
}  // namespace diaphane::render
