#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "renderd/kernel/exact_estimator.h"
#include "renderd/scene/exact_tables.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

// Tests parts of the exact walk whose errors are hard to see in whole pictures: a cell along which
// the value has two turning points, rays that end by chance, pieces closer than two voxel values,
// and matter beyond a light.

namespace diaphane::render {
namespace {

/// Steep and gentle pieces over the values 0 to 30000.
diaphane::v1::Scene stepped_scene(double extinction) {
  diaphane::v1::Scene scene = test::skull_scene();
  auto& function = *scene.mutable_transfer_function();
  function.clear_channels();
  test::add_channel(function, {{3000, 0}, {5000, 0.3}, {9000, 0.1}, {9500, 0.7}, {14000, 0}});
  test::add_channel(function, {{16000, 0}, {21000, 1}, {24000, 0.2}, {30000, 0.9}});
  function.set_extinction_per_mm(extinction);
  return scene;
}

/// One cell between voxel centres, with corner values from 0 to 30000.
volume::Volume one_cell(Random& random) {
  return test::make_volume({2, 2, 2}, {1, 1, 1}, [&](double, double, double) {
    // Most corners have one of the end values, because the value turns between unlike corners.
    const float u = random.one();
    return u < 0.3f ? 0.0 : u > 0.7f ? 30000.0 : 30000.0 * random.one();
  });
}

/// Returns the number of turning points of the value along a crossing.
int turns_of(const Corners& corners, const Crossing& segment) {
  int turns = 0;
  double before = 0;
  const auto value = [&](int i) {
    return double{corners.at(
        segment.at(segment.t0 + (segment.t1 - segment.t0) * static_cast<float>(i) / 200))};
  };
  for (int i = 0; i < 200; ++i) {
    const double rise = value(i + 1) - value(i);
    if (std::abs(rise) < 1) continue;
    turns += before * rise < 0;
    before = rise;
  }
  return turns;
}

/// Integrates numerically; 0.1 mm has 2000 steps. At each of about ten kinks the error of the
/// midpoint rule is less than a step's change of the extinction, 1e-4 in total.
double stepped_depth(const TransferView& function, const Corners& corners, const Crossing& segment,
                     float end) {
  constexpr int kSteps = 20'000;
  double depth = 0;
  const double length = double{end} - segment.t0;
  for (int i = 0; i < kSteps; ++i) {
    const auto t = static_cast<float>(segment.t0 + length * (i + 0.5) / kSteps);
    depth += extinction_at(function, corners.at(segment.at(t)));
  }
  return depth * length / kSteps;
}

/// Returns the depth of a ray through the one cell, whose lower corner is the centre of the first
/// voxel.
float walked_depth(const SceneView<LinearVolume>& view, const Crossing& segment) {
  DepthWalk<Features{}.with(Feature::kCurves), LinearVolume> walk(
      Ray{segment.origin + Float3{0.5f, 0.5f, 0.5f}, segment.direction},
      Span{segment.t0, segment.t1}, view.volume, view.exact);
  CellCrossing<LinearVolume> c;
  while (!walk.ended()) walk.step(view.volume, view.exact, c);
  return walk.depth();
}

TEST(ExactCell, MatchesRayMarchingForNonMonotonicValues) {
  Random random(21, 0, 0);
  int by_turns[4] = {0, 0, 0, 0};
  for (int i = 0; i < 6000 && by_turns[2] < 60; ++i) {
    const test::Prepared p(one_cell(random), stepped_scene(2));
    const auto view = p.view();
    const Corners corners = view.volume.corners({1, 1, 1}, {});
    // Rays cross the cell from side to side, because shorter ones have fewer turning points.
    const Random::Pair a = random.two(), b = random.two();
    const Float3 from{a.a, a.b, 0.0f}, to{b.a, b.b, 1.0f};
    const float length = sqrtf(dot(to - from, to - from));
    const Crossing segment{from, (to - from) * (1 / length), 0.0f, length};
    const int turns = turns_of(corners, segment);
    if (turns < 2 && i % 20 != 0) continue;
    ++by_turns[std::min(turns, 3)];
    const float depth = walked_depth(view, segment);
    ASSERT_NEAR(depth, stepped_depth(view.transfer, corners, segment, segment.t1), 5e-4) << turns;
    for (const float share : {0.2f, 0.7f, 0.95f}) {
      const float place = place_in_cell<true>(corners, segment, view.exact, share * depth);
      ASSERT_NEAR(stepped_depth(view.transfer, corners, segment, place), share * depth, 5e-4);
    }
  }
  EXPECT_GE(by_turns[2], 60) << "twice";
  EXPECT_GE(by_turns[1], 20) << "once";
}

/// Matter so dense that rays end by chance, but some arrive: depths from 5 to 8.
struct Thick {
  test::Prepared scene{test::constant_volume(10, 20'000), [] {
                         auto thick = test::skull_scene();
                         auto& function = *thick.mutable_transfer_function();
                         function.clear_channels();
                         test::add_channel(function, {{10'000, 0}, {30'000, 1}});
                         function.set_extinction_per_mm(1.4);
                         return thick;
                       }()};

  /// Returns a ray along x through `length` voxels of 1 mm.
  static std::pair<Ray, Span> segment(float length) {
    return {Ray{{0.0f, 4.3f, 5.6f}, {1.0f, 0.0f, 0.0f}}, Span{0.0f, length}};
  }
};

constexpr Features kCurved =
    Features{}.with(Feature::kAreaLights).with(Feature::kEnvironment).with(Feature::kCurves);

/// A ray arrives with the probability exp(-(depth - certain)), and its transmittance is then
/// exp(-certain). The test uses a binomial count of 40,000 rays, with a significance of 1e-5 for
/// all four lengths.
template <typename Transmittance>
void expect_beer_and_lambert(float certain, const Transmittance& transmittance) {
  constexpr int kRays = 40'000;
  const double limit = test::critical_z(test::sidak(1e-5, 4));
  for (const float length : {7.5f, 8.5f, 9.5f, 10.0f}) {
    test::Moments moments;
    Random random(31, 0, 0);
    for (int i = 0; i < kRays; ++i) moments.add(transmittance(length, random));
    const double depth = 0.7 * length;
    ASSERT_GT(depth, certain);
    const double p = std::exp(certain - depth), once = std::exp(-certain);
    const double spread = once * std::sqrt(p * (1 - p) / kRays);
    // The extinction in the table has a relative error of at most 1e-5.
    EXPECT_NEAR(moments.mean, std::exp(-depth), limit * spread + 1e-4 * std::exp(-depth)) << depth;
  }
}

TEST(TransmittanceWalk, MeanFollowsBeerLambertBeyondRussianRoulette) {
  const Thick thick;
  const auto view = thick.scene.view();
  expect_beer_and_lambert(kCertainDepth, [&](float length, Random& random) {
    const auto [ray, span] = Thick::segment(length);
    CellCrossing<LinearVolume> passed;
    TransmittanceWalk<kCurved, LinearVolume> walk(ray, span, view.volume, view.exact,
                                                  random.exponential());
    while (!walk.ended()) walk.step(view.volume, view.exact, passed);
    return double{walk.transmittance()};
  });
}

TEST(FindHits, RemainingTransmittanceFollowsBeerLambert) {
  const Thick thick;
  auto view = thick.scene.view();
  for (auto& strata : view.exact.strata) strata = 0;
  view.exact.strata[2] = 4;
  const float furthest = target_depth(3, 4, 0.9f);
  expect_beer_and_lambert(furthest, [&](float length, Random& random) {
    const auto [ray, span] = Thick::segment(length);
    const FirstWalk first = find_hits<kCurved>(
        ray, span, view.volume, view.exact,
        [](const HitNumber& hit) { return target_depth(hit.stratum, 4, 0.9f); },
        random.exponential(), true, [](auto&&...) {});
    return double{first.transmittance};
  });
}

TEST(ExactTables, FindTheContainingPieceForEveryValue) {
  // There are eight nodes per voxel value, and the function bends at nearly each of them.
  constexpr double kScale = 8;
  Random random(41, 0, 0);
  std::vector<float> table;
  for (int i = 0; i <= 20 * 8; ++i) table.push_back(i % 5 == 0 ? 0.0f : random.one());
  ValueGrid grid;
  grid.whole = {-7, 13};
  const ExactTables t =
      make_exact_tables(table.data(), static_cast<std::int32_t>(table.size()), kScale, grid);
  ASSERT_GT(t.pieces.size(), 100u);
  ExactView view{};
  view.pieces = t.pieces.data();
  view.piece_of = t.piece_of.data();
  view.piece_count = static_cast<std::int32_t>(t.pieces.size());
  view.first_value = grid.whole.minimum;
  view.last_value = grid.whole.maximum;
  for (int i = 0; i <= 20 * 64; ++i) {
    const float value = -7 + static_cast<float>(i) / 64;
    const ExtinctionPiece& piece = t.pieces[static_cast<std::size_t>(view.piece_at(value))];
    ASSERT_LE(piece.begin, value);
    ASSERT_GE(piece.end, value);
    const double node = (value + 7) * kScale;
    const auto below = std::min(static_cast<std::size_t>(node), table.size() - 2);
    const double part = node - static_cast<double>(below);
    ASSERT_NEAR(extinction_in(piece, value), (1 - part) * table[below] + part * table[below + 1],
                1e-5)
        << value;
  }
}

TEST(ExactEstimate, MediumBehindALampCastsNoShadow) {
  // A lamp shines on a floor. Above the lamp is a ceiling that would absorb all of its light.
  const auto volume = test::make_volume({24, 24, 24}, {1, 1, 1}, [](double, double, double z) {
    return z < 8 ? 12'000 : z > 18 ? 30'000 : 0;
  });
  auto scene = test::skull_scene();
  scene.clear_lights();
  // The volume extends from -12 to 12 mm in z, so the lamp is between floor and ceiling.
  test::add_lamp(scene, 0, 0, 2, 8, 30);
  test::set_camera(scene, 0, 60, 2, 30);
  const test::Prepared p(volume, scene, {16, 16});
  test::Moments exact, tracked;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto view = p.view(seed);
    double a = 0, b = 0;
    for (std::uint32_t pixel = 0; pixel < 256; ++pixel) {
      a += exact_estimate<kCurved>(view, pixel % 16, pixel / 16, 0).radiance.y;
      for (std::uint32_t s = 0; s < 8; ++s) {
        b += estimate<kCurved.with(Feature::kSteepExtinction)>(view, pixel % 16, pixel / 16, s)
                 .radiance.y /
             8;
      }
    }
    exact.add(a / 256);
    tracked.add(b / 256);
  }
  EXPECT_GT(exact.mean, 0.02) << "the floor is lit";
  EXPECT_LT(std::abs(test::welch(exact, tracked)), test::critical_t(1e-4, 60))
      << exact.mean << " against " << tracked.mean;
}

}  // namespace
}  // namespace diaphane::render
