#include "renderd/scene/transfer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "renderd/kernel/medium.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render {
namespace {

using test::add_channel;

TEST(Material, AveragesColourAndTakesTheMaximumOpacity) {
  diaphane::v1::TransferFunction f;
  add_channel(f, {{0, 0}, {100, 1}}, 1, 0, 0);
  add_channel(f, {{50, 0.2}, {150, 0.2}}, 0, 1, 0);
  add_channel(f, {{0, 1}, {200, 1}}, 0, 0, 1)->set_disabled(true);
  const Material both = material_at(f, 60);
  EXPECT_DOUBLE_EQ(both.opacity, 0.6);
  EXPECT_DOUBLE_EQ(both.weighted_albedo.x / both.weight, 0.6 / 0.8);
  EXPECT_DOUBLE_EQ(both.weighted_albedo.y / both.weight, 0.2 / 0.8);
  EXPECT_DOUBLE_EQ(both.weighted_albedo.z, 0) << "disabled";
  EXPECT_DOUBLE_EQ(material_at(f, 150).opacity, 0.2) << "the range is closed";
  EXPECT_DOUBLE_EQ(material_at(f, 150.001).opacity, 0);
  EXPECT_DOUBLE_EQ(material_at(f, -1).weight, 0);
}

TEST(Tables, AreExactAtIntegerCtValues) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.clear_transfer_function();
  auto& f = *scene.mutable_transfer_function();
  add_channel(f, {{-300, 0}, {40, 0.3}, {41, 0.9}, {700, 1}}, 0.5, 0.6, 0.7);
  add_channel(f, {{200, 1}, {3000, 0.1}}, 0.9, 0.1, 0.2);
  f.set_extinction_per_mm(2.5);
  const test::Prepared p(
      test::make_volume({2, 2, 2}, {1, 1, 1},
                        [](double x, double, double) { return x < 1 ? -1024 : 3071; }),
      scene);
  const TransferView t = p.view().transfer;
  for (int v = -1024; v <= 3071; ++v) {
    const Material m = material_at(f, v);
    ASSERT_NEAR(extinction_at(t, static_cast<float>(v)), 2.5 * m.opacity, 1e-6) << v;
    if (m.weight > 0) {
      ASSERT_NEAR(albedo_at(t, static_cast<float>(v)).y, m.weighted_albedo.y / m.weight, 1e-6) << v;
    }
  }
}

TEST(Tables, KeepPointsCloserThanOneUnit) {
  diaphane::v1::Scene scene = test::skull_scene();
  scene.clear_transfer_function();
  auto& f = *scene.mutable_transfer_function();
  add_channel(f, {{99.5, 0}, {99.75, 1}, {100, 0}});
  f.set_extinction_per_mm(1);
  const test::Prepared p(
      test::make_volume({2, 2, 2}, {1, 1, 1},
                        [](double x, double, double) { return x < 1 ? -1024 : 3071; }),
      scene);
  EXPECT_NEAR(extinction_at(p.view().transfer, 99.75f), 1, 1e-3);
}

/// A function for which bounds are easily wrong, to be used on noise with large differences between
/// neighbours.
diaphane::v1::TransferFunction spikes() {
  diaphane::v1::TransferFunction f;
  add_channel(f, {{-20000, 0}, {-19990, 1}, {-19980, 0}});
  add_channel(f, {{100, 1e-6}, {5000, 1e-6}});
  add_channel(f, {{2000, 1}, {2004, 1}});  // jumps at both ends
  add_channel(f, {{-5, 0}, {0, 1}, {5, 0}});
  add_channel(f, {{25000, 0}, {30000, 0.7}, {31000, 0.1}, {32767, 0.4}});
  f.set_extinction_per_mm(1e6);
  return f;
}
diaphane::v1::TransferFunction falling() {
  diaphane::v1::TransferFunction f;
  add_channel(f, {{-32768, 1}, {32767, 0}});
  f.set_extinction_per_mm(3);
  return f;
}

TEST(Majorants, BoundTheExtinctionOfSpikesAndFallingFunctions) {
  for (const auto& function : {spikes(), falling()}) {
    for (const double range : {40.0, 3000.0, 65535.0}) {
      diaphane::v1::Scene scene = test::skull_scene();
      *scene.mutable_transfer_function() = function;
      Random noise(1, 2, 3);
      const test::Prepared p(test::make_volume({37, 20, 16}, {1, 1, 1},
                                               [&](double, double, double) {
                                                 return std::clamp((noise.one() - 0.5) * range,
                                                                   -32768.0, 32767.0);
                                               }),
                             scene);
      const SceneView<LinearVolume> view = p.view();
      Random random(4, 5, 6);
      for (int i = 0; i < 300'000; ++i) {
        const Random::Pair a = random.two(), b = random.two();
        const Int3 cell{static_cast<std::int32_t>(a.a * static_cast<float>(view.grid.size.x)),
                        static_cast<std::int32_t>(a.b * static_cast<float>(view.grid.size.y)),
                        static_cast<std::int32_t>(b.a * static_cast<float>(view.grid.size.z))};
        // A place anywhere in the cell or up to a third of a voxel beyond it, where rounding may
        // put it.
        const Random::Pair c = random.two();
        const auto place = [](std::int32_t n, float u) {
          return static_cast<float>(n * kCellSize) + u * (kCellSize + 0.66f) - 0.33f;
        };
        const float e = extinction_at(
            view.transfer,
            view.volume.at({place(cell.x, b.b), place(cell.y, c.a), place(cell.z, c.b)}));
        const CellBounds bounds =
            view.grid.cells[cell.x + view.grid.size.x * (cell.y + view.grid.size.y * cell.z)];
        ASSERT_LE(e, bounds.majorant) << "range " << range;
        ASSERT_GE(e, bounds.minorant) << "range " << range;
      }
    }
  }
}

/// Noise hides a bound that omits a neighbour, because other voxels of the cell are as large. A
/// single bright or dark voxel does not.
TEST(Majorants, BoundSingleVoxelsOfNeighbouringCells) {
  const Int3 size{20, 18, 19};
  diaphane::v1::Scene scene = test::skull_scene();
  for (const double lone : {30000.0, 0.0}) {
    for (int at = 5; at <= 10; ++at) {
      const test::Prepared p(test::make_volume({20, 18, 19}, {1, 1, 1},
                                               [&](double x, double y, double z) {
                                                 const bool here = static_cast<int>(x) == at &&
                                                                   static_cast<int>(y) == at &&
                                                                   static_cast<int>(z) == at;
                                                 return here ? lone : 30000 - lone;
                                               }),
                             scene);
      const SceneView<LinearVolume> view = p.view();
      // Steps of an eighth of a voxel include the borders of cells. A place on a border is checked
      // in both cells.
      for (int z = 8 * (at - 1); z <= 8 * (at + 2); ++z) {
        for (int y = 8 * (at - 1); y <= 8 * (at + 2); ++y) {
          for (int x = 8 * (at - 1); x <= 8 * (at + 2); ++x) {
            const int place[] = {x, y, z}, n[] = {size.x, size.y, size.z};
            const float e = extinction_at(view.transfer,
                                          view.volume.at(Float3{0.125f * static_cast<float>(x),
                                                                0.125f * static_cast<float>(y),
                                                                0.125f * static_cast<float>(z)}));
            for (int side = 0; side < 8; ++side) {
              int cell[3];
              for (int axis = 0; axis < 3; ++axis) {
                const int eighth = place[axis] - (side >> axis & 1);
                cell[axis] = std::clamp(eighth / 8, 0, n[axis] - 1) / kCellSize;
              }
              const CellBounds bounds =
                  view.grid
                      .cells[cell[0] + view.grid.size.x * (cell[1] + view.grid.size.y * cell[2])];
              ASSERT_LE(e, bounds.majorant) << "voxel " << at;
              ASSERT_GE(e, bounds.minorant) << "voxel " << at;
            }
          }
        }
      }
    }
  }
}

TEST(Majorants, AreTightForConstantValues) {
  diaphane::v1::Scene scene = test::skull_scene();
  const test::Prepared p(test::constant_volume(9, 15000), scene);
  for (const CellBounds& b : p.scene().transfer->bounds) {
    EXPECT_NEAR(b.majorant, 0.4, 1e-5);
    EXPECT_NEAR(b.minorant, 0.4, 1e-5);
  }
}

TEST(ValueGrid, StoresTheRangeOfEveryDilatedCell) {
  Random noise(1, 2, 3);
  const volume::Volume v = test::make_volume(
      {19, 9, 17}, {1, 1, 1}, [&](double, double, double) { return noise.one() * 60000 - 30000; });
  const Int3 size = size_of(v.header);
  const ValueGrid grid = make_value_grid(v.voxels, size);
  ASSERT_EQ(grid.cells.x, 3);
  ASSERT_EQ(grid.cells.y, 2);
  ASSERT_EQ(grid.cells.z, 3);
  std::size_t cell = 0;
  for (int cz = 0; cz < 3; ++cz) {
    for (int cy = 0; cy < 2; ++cy) {
      for (int cx = 0; cx < 3; ++cx, ++cell) {
        std::int16_t low = 32767, high = -32768;
        for (int z = std::max(8 * cz - 1, 0); z <= std::min(8 * cz + 8, size.z - 1); ++z) {
          for (int y = std::max(8 * cy - 1, 0); y <= std::min(8 * cy + 8, size.y - 1); ++y) {
            for (int x = std::max(8 * cx - 1, 0); x <= std::min(8 * cx + 8, size.x - 1); ++x) {
              const std::int16_t value = v.voxels[static_cast<std::size_t>(x + 19 * (y + 9 * z))];
              low = std::min(low, value);
              high = std::max(high, value);
            }
          }
        }
        EXPECT_EQ(grid.ranges[cell].minimum, low);
        EXPECT_EQ(grid.ranges[cell].maximum, high);
      }
    }
  }
}

}  // namespace
}  // namespace diaphane::render
