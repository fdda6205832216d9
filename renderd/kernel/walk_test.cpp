#include "renderd/kernel/walk.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "renderd/math/random.h"

namespace diaphane::render {
namespace {

/// A box in voxels and the grid around it.
struct Setting {
  Int3 size;
  GridView grid;

  explicit Setting(Int3 voxels) : size(voxels) {
    const auto cells = [](std::int32_t n) { return (n + kCellSize - 1) / kCellSize; };
    grid.cells = nullptr;
    grid.size = {cells(size.x), cells(size.y), cells(size.z)};
    grid.occupied = {
        {0, 0, 0},
        {static_cast<float>(size.x), static_cast<float>(size.y), static_cast<float>(size.z)}};
  }
};

/// Walks and checks all invariants. Returns the number of pieces.
int walk_and_check(const Setting& s, const Ray& ray) {
  const Span span = clip(ray, s.grid.occupied, Span{0.0f, 3.4e38f});
  if (!(span.begin < span.end)) return 0;
  CellWalk walk(ray, span, s.grid);
  const int most = s.grid.size.x + s.grid.size.y + s.grid.size.z + 1;
  float reached = span.begin;
  int pieces = 0;
  do {
    EXPECT_EQ(walk.begin(), reached) << "a gap or an overlap";
    EXPECT_GE(walk.end(), walk.begin()) << "backwards";
    EXPECT_GE(walk.cell(), 0);
    EXPECT_LT(walk.cell(), s.grid.size.x * s.grid.size.y * s.grid.size.z);
    reached = walk.end();
    const Float3 middle = ray.at(0.5f * (walk.begin() + walk.end()));
    const int x = walk.cell() % s.grid.size.x;
    const int y = walk.cell() / s.grid.size.x % s.grid.size.y;
    const int z = walk.cell() / (s.grid.size.x * s.grid.size.y);
    const int cell[] = {x, y, z};
    for (int axis = 0; axis < 3; ++axis) {
      // The bounds of a cell allow for half a voxel.
      EXPECT_GE(middle[axis], static_cast<float>(cell[axis] * kCellSize) - 0.25f);
      EXPECT_LE(middle[axis], static_cast<float>((cell[axis] + 1) * kCellSize) + 0.25f);
    }
    if (++pieces > most) {
      ADD_FAILURE() << "does not end";
      break;
    }
  } while (walk.advance());
  // The grid may end before the span by a rounding error, but never by a thousandth of a voxel.
  const float slack = 1e-3f / max(length(ray.direction), 1e-6f);
  EXPECT_NEAR(reached, span.end, slack);
  return pieces;
}

TEST(CellWalk, VisitsTheRightCellsWithoutGaps) {
  const Int3 sizes[] = {{1, 1, 1}, {8, 8, 8}, {9, 1, 200}, {256, 256, 108}, {33, 70, 12}};
  Random random(1, 2, 3);
  for (const Int3 size : sizes) {
    const Setting setting(size);
    const Float3 high = setting.grid.occupied.high;
    int pieces = 0;
    for (int i = 0; i < 20'000; ++i) {
      const Random::Pair a = random.two(), b = random.two(), c = random.two();
      const Float3 from{(3 * a.a - 1) * high.x, (3 * a.b - 1) * high.y, (3 * b.a - 1) * high.z};
      const Float3 to{b.b * high.x, c.a * high.y, c.b * high.z};
      const Float3 d = to - from;
      pieces += walk_and_check(setting, Ray{from, d * (1.0f / length(d))});
      ASSERT_FALSE(::testing::Test::HasFailure()) << "ray " << i;
    }
    EXPECT_GE(pieces, 20'000) << "every ray here meets the box";
  }
}

TEST(CellWalk, EndsForRaysAlongAxesEdgesAndDiagonals) {
  const Setting setting({64, 64, 64});
  const float zero[] = {0.0f, -0.0f};
  for (float none : zero) {
    for (float offset : {0.0f, 8.0f, 16.0f, 31.5f, 64.0f}) {
      EXPECT_EQ(walk_and_check(setting, Ray{{-5, offset, offset}, {1, none, none}}), 8);
      EXPECT_EQ(walk_and_check(setting, Ray{{offset, 69, offset}, {none, -1, none}}), 8);
      EXPECT_EQ(walk_and_check(setting, Ray{{offset, offset, -5}, {none, none, 1}}), 8);
    }
    walk_and_check(setting, Ray{{-8, -8, 16}, {0.70710678f, 0.70710678f, none}});
  }
  walk_and_check(setting, Ray{{-8, -8, -8}, {0.57735027f, 0.57735027f, 0.57735027f}});
  walk_and_check(setting, Ray{{72, 72, 72}, {-0.57735027f, -0.57735027f, -0.57735027f}});
  EXPECT_EQ(walk_and_check(setting, Ray{{32, 32, 32}, {0, 0, 1}}), 4) << "from inside";
  EXPECT_EQ(walk_and_check(setting, Ray{{-1, 32, 32}, {-1, 0, 0}}), 0) << "away";
  EXPECT_EQ(walk_and_check(setting, Ray{{-1, 65, 32}, {1, 0, 0}}), 0) << "beside";
  // Directions that are almost along an axis.
  walk_and_check(setting, Ray{{-5, 8, 8}, {1, 1e-20f, -1e-30f}});
  walk_and_check(setting, Ray{{-5, 8, 8}, {1, 1e-7f, -1e-7f}});
}

TEST(Clip, EveryRayMissesAnEmptyBox) {
  const Box nothing{{0, 0, 0}, {0, 0, 0}};
  const Float3 directions[] = {{1, 0, 0}, {0.6f, 0.8f, 0}, {0, -1, -0.0f}, {1, 1, 1}};
  for (const Float3 d : directions) {
    const Span s = clip(Ray{{0, 0, 0}, d}, nothing, Span{0, 3.4e38f});
    EXPECT_FALSE(s.begin < s.end);
  }
}

}  // namespace
}  // namespace diaphane::render
