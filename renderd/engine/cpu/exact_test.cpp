#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "renderd/kernel/exact_estimator.h"
#include "renderd/scene/exact_tables.h"
#include "tests/support/renderd/test_scenes.h"
#include "tests/support/renderd/test_statistics.h"

// Compares the exact walk with numerical integration and with tracking.

namespace diaphane::render {
namespace {

/// Curves with a spike, a plateau, an overlap and a jump, over the values of skull_volume.
diaphane::v1::Scene curves_scene() {
  diaphane::v1::Scene scene = test::skull_scene();
  auto& function = *scene.mutable_transfer_function();
  function.clear_channels();
  test::add_channel(function, {{2000, 0}, {4000, 0.02}, {9000, 0}}, 0.9, 0.3, 0.2);
  test::add_channel(function, {{8000, 0}, {8400, 0.9}, {8800, 0}}, 0.2, 0.8, 0.3);
  test::add_channel(function, {{15000, 0.1}, {20000, 0.1}}, 0.3, 0.3, 0.9);
  test::add_channel(function, {{18000, 0}, {30000, 1}}, 0.9, 0.85, 0.75);
  return scene;
}

struct RaySegment {
  Ray ray;
  Span span;
};

/// Returns rays through the volume in all directions, some of them along axes and planes.
std::vector<RaySegment> segments(const SceneView<LinearVolume>& view, int count) {
  Random random(7, 0, 0);
  std::vector<RaySegment> out;
  const Box box{{0, 0, 0},
                {static_cast<float>(view.volume.size.x), static_cast<float>(view.volume.size.y),
                 static_cast<float>(view.volume.size.z)}};
  for (int i = 0; i < count; ++i) {
    const Random::Pair a = random.two(), b = random.two(), c = random.two();
    Float3 d = sample_sphere(a.a, a.b);
    Float3 inside{b.a * box.high.x, b.b * box.high.y, c.a * box.high.z};
    if (i % 8 == 0) d = {0.0f, i % 16 == 0 ? 1.0f : -1.0f, 0.0f};
    if (i % 24 == 0) inside = {std::floor(inside.x), inside.y, std::floor(inside.z) + 0.5f};
    if (i % 8 == 1) d.z = -0.0f;
    const Float3 unit = normalize(d);
    const Ray ray{(inside * view.spacing - unit * 200.0f) * view.inverse_spacing,
                  unit * view.inverse_spacing};
    out.push_back({ray, clip(ray, box, Span{i % 5 == 0 ? 200.0f : 0.0f, 3.4e38f})});
  }
  return out;
}

double walked_depth(const SceneView<LinearVolume>& view, const RaySegment& segment,
                    int* cells = nullptr) {
  DepthWalk<Features{}.with(Feature::kCurves), LinearVolume> walk(segment.ray, segment.span,
                                                                  view.volume, view.exact);
  CellCrossing<LinearVolume> c;
  double depth = 0;
  float before = 0;
  while (!walk.ended()) {
    if (!walk.step(view.volume, view.exact, c)) continue;
    // The sum is in double precision, because each cell is tested.
    depth += double{walk.depth()} - before;
    before = walk.depth();
    if (cells != nullptr) ++*cells;
  }
  return depth;
}

double stepped_depth(const SceneView<LinearVolume>& view, const RaySegment& segment) {
  const int steps = 40000;
  const double length = double{segment.span.end} - segment.span.begin;
  double depth = 0;
  for (int i = 0; i < steps; ++i) {
    const auto t = static_cast<float>(segment.span.begin + length * (i + 0.5) / steps);
    depth += extinction_at(view.transfer, view.volume.at(segment.ray.at(t)));
  }
  return depth * length / steps;
}

TEST(ExactWalk, OpticalDepthMatchesRayMarching) {
  for (const auto& scene : {test::skull_scene(), curves_scene()}) {
    const test::Prepared p(test::skull_volume(), scene);
    const auto view = p.view();
    double most = 0;
    for (const RaySegment& segment : segments(view, test::gate_or_nightly(32, 96))) {
      if (!(segment.span.begin < segment.span.end)) continue;
      const double walked = walked_depth(view, segment), stepped = stepped_depth(view, segment);
      // 40,000 steps over at most 110 mm are 3 um each. At each kink and border the error of the
      // midpoint rule is at most a step's change of the extinction, 0.002 in total for these
      // functions.
      ASSERT_NEAR(walked, stepped, 0.002 + 2e-4 * stepped);
      most = std::max(most, walked);
    }
    EXPECT_GT(most, 1) << "no ray hit the medium";
  }
}

TEST(ExactWalk, VisitsEveryNonEmptyCell) {
  // A walk through all bricks must hit no more matter than a walk that skips the empty ones.
  const test::Prepared p(test::skull_volume(), curves_scene());
  const auto view = p.view();
  auto full = view;
  std::vector<std::uint8_t> none = p.scene().transfer->exact.skips;
  for (auto& skip : none) skip = skip == kOutside ? kOutside : 0;
  full.exact.skips = none.data() + BrickArray(p.grid().bricks).first;
  int cells = 0, all = 0;
  for (const RaySegment& segment : segments(view, 400)) {
    if (!(segment.span.begin < segment.span.end)) continue;
    const double skipping = walked_depth(view, segment, &cells),
                 walking = walked_depth(full, segment, &all);
    // In fp32, coordinates near 200 mm place the borders of each cell with an error of 1e-5 of a
    // cell.
    ASSERT_NEAR(skipping, walking, 1e-4 + 1e-4 * walking);
  }
  EXPECT_LT(cells, all / 2) << "and something is skipped";
}

TEST(ExactTables, SkipsSpanTheLargestEmptyCubes) {
  const Int3 bricks{9, 7, 6};
  std::vector<std::uint8_t> occupied(static_cast<std::size_t>(9 * 7 * 6), 0);
  Random random(3, 0, 0);
  for (auto& o : occupied) o = random.one() < 0.05f;
  const auto skips = make_skips(occupied, bricks);
  const auto at = [&](int x, int y, int z) {
    return x < 0 || y < 0 || z < 0 || x >= bricks.x || y >= bricks.y || z >= bricks.z
               ? 0
               : int{occupied[static_cast<std::size_t>(x + 9 * (y + 7 * z))]};
  };
  for (int octant = 0; octant < 8; ++octant) {
    const int sx = (octant & 1) ? 1 : -1, sy = (octant & 2) ? 1 : -1, sz = (octant & 4) ? 1 : -1;
    for (int b = 0; b < 9 * 7 * 6; ++b) {
      const int x = b % 9, y = b / 9 % 7, z = b / 63;
      const BrickArray array(bricks);
      const int skip =
          skips[static_cast<std::size_t>(octant * array.count + array.index({x, y, z}))];
      const auto empty = [&](int n) {
        for (int i = 0; i < n * n * n; ++i) {
          if (at(x + sx * (i % n), y + sy * (i / n % n), z + sz * (i / n / n)) != 0) return false;
        }
        return true;
      };
      ASSERT_TRUE(empty(std::min(skip, 10))) << b << " " << octant;
      if (skip < 10) ASSERT_FALSE(empty(skip + 1)) << b << " " << octant;
    }
  }
}

TEST(ExactTables, PiecesReproduceTheTable) {
  std::vector<float> table;
  for (int i = 0; i <= 4000; ++i) {
    const double v = i < 1000   ? 0
                     : i < 2000 ? (i - 1000) * 1e-9
                     : i < 3000 ? 1e-6
                                : std::min(1e6, (i - 2999) * 5e4);
    table.push_back(static_cast<float>(v));
  }
  const auto pieces = join_pieces(table.data(), static_cast<std::int32_t>(table.size()), 1, -500);
  EXPECT_LE(pieces.size(), 7u);
  for (int i = 0; i <= 4000; ++i) {
    const float value = static_cast<float>(i - 500);
    const ExtinctionPiece* in = &pieces.front();
    for (const auto& piece : pieces) {
      if (piece.begin <= value) in = &piece;
    }
    const double given = in->extinction + in->slope * (value - in->begin);
    ASSERT_NEAR(given, table[static_cast<std::size_t>(i)],
                2e-6 * table[static_cast<std::size_t>(i)])
        << i;
  }
}

TEST(OpacityStrata, CoverTheOpacityRangeAndWeightHitsByWidth) {
  for (std::int32_t count = 1; count <= kMostHits; ++count) {
    double end = 0;
    for (std::int32_t i = 0; i < count; ++i) {
      const OpacityStratum stratum(i, count);
      EXPECT_NEAR(stratum.begin, end, 1e-6) << i << " of " << count;
      EXPECT_GT(stratum.width, 0);
      end = stratum.begin + stratum.width;
    }
    EXPECT_NEAR(end, 1, 1e-6) << count;
    // The light falls with the square of the remaining transmittance, so its mean is 1/3. Every
    // other stratum is mirrored, so for each single offset the sum is close to it.
    constexpr int kOffsets = 1000;
    double sum = 0, furthest = 0;
    for (int k = 0; k < kOffsets; ++k) {
      const float offset = (static_cast<float>(k) + 0.5f) / kOffsets;
      double light = 0;
      for (std::int32_t i = 0; i < count; ++i) {
        const double left = std::exp(-double{target_depth(i, count, offset)});
        light += OpacityStratum(i, count).width * left * left;
      }
      sum += light / kOffsets;
      furthest = std::max(furthest, std::abs(light - 1.0 / 3));
    }
    EXPECT_NEAR(sum, 1.0 / 3, 1e-5) << count;
    if (count % 2 == 0) EXPECT_LT(furthest, 0.5 / (count * count)) << count;
  }
}

TEST(FindHits, HitsLieWhereTheOpacityReachesTheirStrata) {
  const test::Prepared p(test::skull_volume(), curves_scene());
  auto view = p.view();
  int found = 0;
  for (const RaySegment& segment : segments(view, 60)) {
    if (!(segment.span.begin < segment.span.end)) continue;
    for (auto& strata : view.exact.strata) strata = 0;
    view.exact.strata[0] = 3;
    view.exact.strata[2] = 4;
    const auto u = [](int kind) { return kind == 0 ? 0.3f : 0.8f; };
    constexpr Features kF =
        Features{}.with(Feature::kAreaLights).with(Feature::kEnvironment).with(Feature::kCurves);
    find_hits<kF>(
        segment.ray, segment.span, view.volume, view.exact,
        [&](const HitNumber& hit) {
          return target_depth(hit.stratum, view.exact.strata[hit.kind], u(hit.kind));
        },
        1.0f, true,
        [&](const HitNumber& number, const CellCrossing<LinearVolume>& c, float to) {
          const Corners corners = view.volume.corners(c.cell, c.brick);
          const float t = place_in_cell<true>(corners, c.segment, view.exact, to);
          const Hit hit{t, corners.at(c.segment.at(t))};
          const OpacityStratum stratum(number.stratum, view.exact.strata[number.kind]);
          const float share = number.stratum % 2 == 0 ? u(number.kind) : 1 - u(number.kind);
          const double opacity = stratum.begin + share * stratum.width;
          const double depth =
              walked_depth(view, {segment.ray, {segment.span.begin, hit.distance}});
          EXPECT_NEAR(-std::expm1(-depth), opacity, 2e-4);
          EXPECT_NEAR(hit.value, view.volume.at(segment.ray.at(hit.distance)), 2.0f);
          ++found;
        });
  }
  EXPECT_GT(found, 100);
}

/// Returns means over tiles of pictures with separate seeds, which are independent whatever the
/// sampling of a picture.
template <typename Estimate>
std::vector<test::Moments> tiles_of(const test::Prepared& p, int pictures, std::uint32_t samples,
                                    const Estimate& estimate) {
  constexpr std::uint32_t kTiles = 4;
  std::vector<test::Moments> tiles(kTiles * kTiles);
  for (int picture = 0; picture < pictures; ++picture) {
    const auto view = p.view(static_cast<std::uint64_t>(picture) + 1);
    std::vector<double> sums(tiles.size());
    for (std::uint32_t y = 0; y < view.height; ++y) {
      for (std::uint32_t x = 0; x < view.width; ++x) {
        for (std::uint32_t s = 0; s < samples; ++s) {
          const Float3 c = estimate(view, x, y, s).radiance;
          sums[x * kTiles / view.width + kTiles * (y * kTiles / view.height)] += c.x + c.y + c.z;
        }
      }
    }
    for (std::size_t i = 0; i < tiles.size(); ++i) tiles[i].add(sums[i] / samples);
  }
  return tiles;
}

TEST(ExactEstimate, MatchesTheMeanOfTracking) {
  static constexpr Features kF =
      Features{}.with(Feature::kAreaLights).with(Feature::kEnvironment).with(Feature::kCurves);
  constexpr double kAlpha = 1e-4;
  auto dense = curves_scene();
  dense.mutable_transfer_function()->set_extinction_per_mm(30);
  auto black = test::skull_scene();
  black.mutable_display()->set_show_environment(false);
  for (const auto& scene : {test::skull_scene(), curves_scene(), dense, black}) {
    const test::Prepared p(test::skull_volume(), scene, {32, 32});
    const auto exact = tiles_of(p, 40, 2, [](const auto& v, auto x, auto y, auto s) {
      return exact_estimate<kF>(v, x, y, s);
    });
    const auto tracked =
        tiles_of(p, 40, test::gate_or_nightly(4u, 16u), [](const auto& v, auto x, auto y, auto s) {
          return estimate<kF.with(Feature::kSteepExtinction)>(v, x, y, s);
        });
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const double limit = test::critical_t(test::sidak(kAlpha, 4 * exact.size()), 60);
      EXPECT_LT(std::abs(test::welch(exact[i], tracked[i])), limit)
          << "tile " << i << ": " << exact[i].mean << " against " << tracked[i].mean;
    }
  }
}

}  // namespace
}  // namespace diaphane::render
