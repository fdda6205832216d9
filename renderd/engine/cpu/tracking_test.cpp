#include "renderd/kernel/tracking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "renderd/kernel/phase.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

// Beer and Lambert: along a straight path, the fraction exp(-optical depth) of the light remains.
// The optical depth of each medium here is known in closed form. Delta tracking must let this
// fraction of rays pass, and the transmittance estimate must have it as its mean.

namespace diaphane::render {
namespace {

constexpr double kAlpha = 1e-3;

diaphane::v1::Scene scene_with(const diaphane::v1::TransferFunction& function) {
  diaphane::v1::Scene scene = test::skull_scene();
  *scene.mutable_transfer_function() = function;
  return scene;
}

struct Case {
  const char* name;
  test::Prepared prepared;
  Ray ray;  ///< the parameter is in mm
  double optical_depth;
};

Case homogeneous(double depth) {
  diaphane::v1::TransferFunction f;
  test::add_channel(f, {{0, 1}, {2000, 1}});
  f.set_extinction_per_mm(depth / 40);
  test::Prepared p(test::constant_volume(20, 1000, 2), scene_with(f));
  return {"homogeneous", std::move(p), Ray{{-3, 10, 10}, {0.5f, 0, 0}}, depth};
}

/// Values rise linearly along x, and the extinction rises linearly with the value. The integral is
/// that of a ramp whose ends are clamped to the border voxels.
Case ramp(double scale) {
  diaphane::v1::TransferFunction f;
  test::add_channel(f, {{0, 0}, {4000, 1}});
  f.set_extinction_per_mm(scale);
  test::Prepared p(test::make_volume({40, 9, 9}, {1, 1, 1},
                                     [](double x, double, double) { return 100 * (x - 0.5); }),
                   scene_with(f));
  // The value rises from 0 to 3900 over 39 mm, with half a voxel at each end.
  const double depth = scale * (39 * 0.5 * 3900 + 0.5 * 3900) / 4000;
  return {"ramp", std::move(p), Ray{{45, 4, 4}, {-1, 0, 0}}, depth};
}

/// Blocks of the values 0 and 1000 along y. Between the two voxels of a step, the extinction is a
/// ramp of one voxel.
Case steps(double scale) {
  diaphane::v1::TransferFunction f;
  test::add_channel(f, {{0, 0}, {1000, 1}});
  f.set_extinction_per_mm(scale);
  test::Prepared p(test::make_volume({9, 48, 9}, {1, 0.5, 1},
                                     [](double, double y, double) {
                                       return static_cast<int>(y) / 6 % 2 == 1 ? 1000 : 0;
                                     }),
                   scene_with(f));
  // Half of 48 voxels of 0.5 mm are dense. The last block ends at the border, so no half ramp is
  // lost there.
  return {"steps", std::move(p), Ray{{4.2f, -2, 3.3f}, {0, 2, 0}}, scale * 24 * 0.5};
}

/// A function that rises, falls and has a narrow peak, along a ramp of values.
Case peak(double scale) {
  diaphane::v1::TransferFunction f;
  test::add_channel(f, {{200, 0}, {1000, 0.2}, {2000, 0.1}});
  test::add_channel(f, {{1500, 0}, {1510, 1}, {1520, 0}});
  f.set_extinction_per_mm(scale);
  test::Prepared p(test::make_volume({40, 9, 9}, {1, 1, 1},
                                     [](double x, double, double) { return 100 * (x - 0.5); }),
                   scene_with(f));
  // The values change by 100 per mm. The peak, 20 units wide, replaces the low channel where it is
  // higher.
  double depth = 0;
  constexpr int kSteps = 4'000'000;
  for (int i = 0; i < kSteps; ++i) {
    const double v = 3900.0 * (i + 0.5) / kSteps;
    const double low = v < 200 || v > 2000 ? 0
                       : v < 1000          ? 0.2 * (v - 200) / 800
                                           : 0.2 - 0.1 * (v - 1000) / 1000;
    const double high = std::max(1 - std::abs(v - 1510) / 10, 0.0);
    depth += std::max(low, high) * 39.0 / kSteps;
  }
  return {"peak", std::move(p), Ray{{-5, 4, 4}, {1, 0, 0}}, scale * depth};
}

/// One dense layer, two voxels thick at half its height, in a clear volume. The extinction is a
/// triangle.
Case spike(double scale) {
  diaphane::v1::TransferFunction f;
  test::add_channel(f, {{900, 0}, {1000, 1}});
  f.set_extinction_per_mm(scale);
  test::Prepared p(test::make_volume({9, 9, 32}, {1, 1, 1},
                                     [](double, double, double z) {
                                       return static_cast<int>(z) == 13 ? 1000 : 0;
                                     }),
                   scene_with(f));
  // The value is above 900 within a tenth of a voxel on each side of the centre of the layer.
  return {"spike", std::move(p), Ray{{4.3f, 4.1f, -2}, {0, 0, 1}}, scale * 0.1};
}

Span inside(const Case& c) {
  return clip(c.ray, c.prepared.view().grid.occupied, Span{0.0f, 3.4e38f});
}

template <bool Steep = false>
bool escapes(const SceneView<LinearVolume>& view, const Ray& ray, Span span, Random& random) {
  return !track<Steep>(ray, span, view.grid, Medium<LinearVolume>{view.volume, view.transfer},
                       random)
              .found;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (double depth : {1e-6, 1e-4, 0.01, 0.5, 3.0, 8.0}) {
    all.push_back(homogeneous(depth));
  }
  for (double scale : {1e-6, 1e-3, 0.05, 0.3}) {
    all.push_back(ramp(scale));
    all.push_back(steps(scale));
    all.push_back(peak(10 * scale));
  }
  return all;
}

TEST(DeltaTracking, TransmissionFollowsBeerLambert) {
  const std::vector<Case> all = cases();
  const double limit = test::critical_z(test::sidak(kAlpha, all.size()));
  for (const Case& c : all) {
    const SceneView<LinearVolume> view = c.prepared.view();
    const Span span = inside(c);
    constexpr std::uint32_t kRays = 300'000;
    std::uint32_t through = 0;
    for (std::uint32_t i = 0; i < kRays; ++i) {
      Random random(1, i, 0);
      through += escapes(view, c.ray, span, random) ? 1 : 0;
    }
    const double p = std::exp(-c.optical_depth);
    EXPECT_NEAR(through, kRays * p, limit * std::sqrt(kRays * p * (1 - p)) + 1)
        << c.name << ", optical depth " << c.optical_depth;
  }
}

TEST(Transmittance, MeanFollowsBeerLambert) {
  const std::vector<Case> all = cases();
  const double limit = test::critical_z(test::sidak(kAlpha, all.size()));
  for (const Case& c : all) {
    const SceneView<LinearVolume> view = c.prepared.view();
    const Span span = inside(c);
    test::Moments moments;
    for (std::uint32_t i = 0; i < 300'000; ++i) {
      Random random(2, i, 0);
      const float t = transmittance(c.ray, span, view.grid,
                                    Medium<LinearVolume>{view.volume, view.transfer}, random);
      ASSERT_GE(t, 0.0f);
      ASSERT_LE(t, 1.0f);
      moments.add(t);
    }
    const double exact = std::exp(-c.optical_depth);
    EXPECT_NEAR(moments.mean, exact, limit * moments.error_of_mean() + 1e-5 * exact)
        << c.name << ", optical depth " << c.optical_depth;
  }
}

TEST(DeltaTracking, HitsVeryThinMediumAtTheExpectedRate) {
  const Case c = homogeneous(1e-6);
  const SceneView<LinearVolume> view = c.prepared.view();
  const Span span = inside(c);
  constexpr std::uint32_t kRays = 20'000'000;
  std::uint32_t hits = 0;
  for (std::uint32_t i = 0; i < kRays; ++i) {
    Random random(3, i, 0);
    hits += escapes(view, c.ray, span, random) ? 0 : 1;
  }
  // A Poisson variable of mean 20 is outside 7 to 37 with probability 1e-3.
  EXPECT_GE(hits, 7u);
  EXPECT_LE(hits, 37u);
}

/// At a depth of 1e4 no ray passes, but the collisions still follow the exponential law.
TEST(DeltaTracking, CollisionsInDenseMediumAreExponential) {
  for (double depth : {100.0, 1e4, 4e6}) {
    const Case c = homogeneous(depth);
    const SceneView<LinearVolume> view = c.prepared.view();
    const Span span = inside(c);
    test::Moments moments;
    for (std::uint32_t i = 0; i < 100'000; ++i) {
      Random random(4, i, 0);
      const Collision hit =
          track(c.ray, span, view.grid, Medium<LinearVolume>{view.volume, view.transfer}, random);
      ASSERT_TRUE(hit.found);
      moments.add(hit.distance - span.begin);
    }
    const double mean = 40 / depth;
    // Near 6 mm, fp32 positions are 5e-7 apart.
    EXPECT_NEAR(moments.mean, mean, test::critical_z(kAlpha / 3) * moments.error_of_mean() + 2.5e-7)
        << depth;
    for (std::uint32_t i = 0; i < 1000; ++i) {
      Random random(5, i, 0);
      ASSERT_LT(transmittance(c.ray, span, view.grid,
                              Medium<LinearVolume>{view.volume, view.transfer}, random),
                1e-30f);
    }
  }
}

/// The optical depth at the collision is exponential with mean 1 for every medium. This also tests
/// media through which no ray passes, where the tests above see only that.
TEST(DeltaTracking, CollisionDepthIsExponential) {
  constexpr int kBins = 101;
  constexpr std::uint64_t kRays = 300'000;
  struct Deep {
    Case medium;
    double (*depth_at)(double scale, double distance);  ///< from the start of the path
    double scale;
  };
  const auto linear = [](double scale, double t) { return scale * t; };
  // The path goes along -x from the end at 40 mm: half a voxel of the largest value, then a falling
  // ramp.
  const auto falling = [](double scale, double t) {
    const double w = std::clamp(t - 0.5, 0.0, 39.0);
    const double ramp = 3900 * w - 50 * w * w;
    return scale / 4000 * (3900 * std::min(t, 0.5) + ramp);
  };
  std::vector<Deep> all;
  for (double depth : {0.5, 20.0, 1e4}) all.push_back({homogeneous(depth), linear, depth / 40});
  for (double scale : {0.05, 1.0, 500.0}) all.push_back({ramp(scale), falling, scale});
  const double alpha = test::sidak(kAlpha, all.size());
  for (const Deep& d : all) {
    const SceneView<LinearVolume> view = d.medium.prepared.view();
    const Span span = inside(d.medium);
    std::vector<std::uint64_t> counts(kBins);
    std::vector<double> probabilities(kBins);
    const double all_of_it = -std::expm1(-d.medium.optical_depth);
    for (double& p : probabilities) p = all_of_it / kBins;
    for (std::uint32_t i = 0; i < kRays; ++i) {
      Random random(9, i, 0);
      const Collision hit = track(d.medium.ray, span, view.grid,
                                  Medium<LinearVolume>{view.volume, view.transfer}, random);
      if (!hit.found) continue;
      const double depth = d.depth_at(d.scale, hit.distance - double{span.begin});
      const double share = -std::expm1(-depth) / all_of_it;
      ++counts[static_cast<std::size_t>(std::clamp(share, 0.0, 0.9999999) * kBins)];
    }
    EXPECT_TRUE(test::chi_square(counts, probabilities, kRays).fits(alpha))
        << d.medium.name << " " << d.scale;
  }
}

/// With a majorant a million times the extinction, no step may be lost to rounding.
TEST(DeltaTracking, IsUnbiasedWithAMajorantAMillionTimesTooLarge) {
  Case c = homogeneous(0.02);
  std::vector<CellBounds> bounds = c.prepared.scene().transfer->bounds;
  for (CellBounds& b : bounds) b = {0, b.majorant * 1e6f};
  SceneView<LinearVolume> view = c.prepared.view();
  view.grid.cells = bounds.data();
  const Span span = inside(c);
  constexpr std::uint32_t kRays = 2000;
  std::uint32_t through = 0;
  for (std::uint32_t i = 0; i < kRays; ++i) {
    Random random(6, i, 0);
    through += escapes(view, c.ray, span, random) ? 1 : 0;
  }
  const double p = std::exp(-c.optical_depth);
  EXPECT_NEAR(through, kRays * p, test::critical_z(kAlpha) * std::sqrt(kRays * p * (1 - p)) + 1);
}

/// The same laws hold if each macrocell is crossed voxel by voxel.
TEST(SteepTracking, TransmissionFollowsBeerLambert) {
  std::vector<Case> all;
  for (double scale : {6.0, 20.0}) {
    all.push_back(spike(scale));
  }
  const double limit = test::critical_z(test::sidak(kAlpha, 2 * all.size()));
  for (const Case& c : all) {
    const SceneView<LinearVolume> view = c.prepared.view();
    ASSERT_TRUE(c.prepared.scene().transfer->steep) << c.optical_depth;
    const Span span = inside(c);
    constexpr std::uint32_t kRays = 200'000;
    std::uint32_t through = 0;
    test::Moments moments;
    for (std::uint32_t i = 0; i < kRays; ++i) {
      Random random(1, i, 0);
      through += escapes<true>(view, c.ray, span, random) ? 1 : 0;
      moments.add(transmittance<true>(c.ray, span, view.grid,
                                      Medium<LinearVolume>{view.volume, view.transfer}, random));
    }
    const double p = std::exp(-c.optical_depth);
    EXPECT_NEAR(through, kRays * p, limit * std::sqrt(kRays * p * (1 - p)) + 1) << c.optical_depth;
    EXPECT_NEAR(moments.mean, p, limit * moments.error_of_mean()) << c.optical_depth;
  }
}

/// Clear and opaque voxels side by side at a million per mm must not make the work unbounded.
TEST(SteepTracking, IsFastBesideAnOpaqueWall) {
  diaphane::v1::TransferFunction f;
  test::add_channel(f, {{500, 0}, {1000, 1}});
  f.set_extinction_per_mm(1e6);
  const test::Prepared p(test::make_volume({64, 64, 64}, {1, 1, 1},
                                           [](double x, double y, double) {
                                             return static_cast<int>(x) % 8 == 4 || y > 60 ? 1000
                                                                                           : 0;
                                           }),
                         scene_with(f));
  const auto view = p.view();
  // Between two walls, four voxels from each, the ray hits nothing.
  const Ray ray{{8.5f, -1, 30}, {0, 1, 0}};
  const Span span = clip(ray, Box{{0, 0, 0}, {64, 59, 64}}, Span{0, 3.4e38f});
  const Medium<LinearVolume> medium{view.volume, view.transfer};
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    Random random(1, i, 0);
    ASSERT_FALSE(track<true>(ray, span, view.grid, medium, random).found);
    ASSERT_EQ(transmittance<true>(ray, span, view.grid, medium, random), 1.0f);
  }
}

/// Compares one bound of the whole volume in every cell, as if there were no grid, with separate
/// bounds for each cell.
TEST(Grid, DoesNotChangeTheEstimate) {
  const test::Prepared prepared(test::skull_volume(), test::skull_scene());
  const SceneView<LinearVolume> with = prepared.view();
  float majorant = 0;
  for (const CellBounds& b : prepared.scene().transfer->bounds) {
    majorant = max(majorant, b.majorant);
  }
  const std::vector<CellBounds> same(prepared.scene().transfer->bounds.size(),
                                     CellBounds{0, majorant});
  SceneView<LinearVolume> without = with;
  without.grid.cells = same.data();
  without.grid.occupied = {{0, 0, 0}, {48, 48, 30}};

  constexpr int kRays = 12;
  const double limit = test::critical_z(test::sidak(kAlpha, 3 * kRays));
  Random directions(7, 7, 7);
  for (int ray_number = 0; ray_number < kRays; ++ray_number) {
    const Random::Pair u = directions.two();
    const Float3 d = sample_sphere(u.a, u.b);
    const Ray ray{Float3{24, 24, 15} - d * 60.0f, d};
    test::Moments escape[2], distance[2], seen[2];
    for (int grid = 0; grid < 2; ++grid) {
      const SceneView<LinearVolume>& view = grid == 0 ? with : without;
      const Medium<LinearVolume> medium{view.volume, view.transfer};
      const Span span = clip(ray, view.grid.occupied, Span{0.0f, 3.4e38f});
      if (!(span.begin < span.end)) continue;
      for (std::uint32_t i = 0; i < 20'000; ++i) {
        Random random(8 + static_cast<std::uint64_t>(grid), i,
                      static_cast<std::uint64_t>(ray_number));
        const Collision hit = track(ray, span, view.grid, medium, random);
        escape[grid].add(hit.found ? 0 : 1);
        if (hit.found) distance[grid].add(hit.distance);
        seen[grid].add(transmittance(ray, span, view.grid, medium, random));
      }
    }
    EXPECT_LT(std::abs(test::welch(escape[0], escape[1])), limit);
    if (distance[0].n > 200 && distance[1].n > 200) {
      EXPECT_LT(std::abs(test::welch(distance[0], distance[1])), limit);
    }
    EXPECT_LT(std::abs(test::welch(seen[0], seen[1])), limit);
  }
}

}  // namespace
}  // namespace diaphane::render
