#include "volume/region.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace diaphane::volume {
namespace {

/// Every voxel differs from every neighbour, and none is air.
Volume numbered(std::array<std::uint32_t, 3> size, std::array<double, 3> spacing, double turn = 0) {
  Volume volume;
  volume.header.size = size;
  volume.header.spacing = spacing;
  const double c = std::cos(turn), s = std::sin(turn);
  volume.header.direction = {c, -s, 0, s, c, 0, 0, 0, 1};
  volume.header.modality = Modality::kCt;
  volume.header.window_center = 40;
  volume.header.window_width = 400;
  volume.header.repairs = {"straightened 18.5 degrees"};
  volume.voxels.resize(volume.header.voxel_count());
  for (std::size_t i = 0; i < volume.voxels.size(); ++i) {
    volume.voxels[i] = static_cast<std::int16_t>(1 + i % 30011);
  }
  volume.voxels.front() = -1024;  // so that air can be -1000
  measure(volume);
  return volume;
}

Vector world_of(const Header& header, const std::array<double, 3>& index) {
  Vector world{};
  for (std::size_t p = 0; p < 3; ++p) {
    for (std::size_t v = 0; v < 3; ++v) {
      world[p] +=
          header.direction[3 * p + v] * header.spacing[v] * (index[v] + 0.5 - header.size[v] / 2.0);
    }
  }
  return world;
}

/// The definition of the region for a single position, independent of intervals and slopes.
bool inside(const Region& region, const Vector& place) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (place[i] < region.low[i] || place[i] > region.high[i]) return false;
  }
  return std::all_of(region.planes.begin(), region.planes.end(), [&](const Region::Plane& plane) {
    double side = 0;
    for (std::size_t i = 0; i < 3; ++i) side += (place[i] - plane.point[i]) * plane.normal[i];
    return side <= 0;
  });
}

std::int16_t at(const Volume& volume, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return volume.voxels[x + std::size_t{volume.header.size[0]} *
                               (y + std::size_t{volume.header.size[1]} * z)];
}

TEST(Region, KeepsVoxelsInsideExactlyAndReplacesOthersByAir) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1), sign(-1, 1);
  const auto side = [&](std::uint32_t least, std::uint32_t range) {
    return least + static_cast<std::uint32_t>(random() % range);
  };
  int cuts = 0;
  for (int round = 0; round < 60; ++round) {
    const Volume old = numbered({side(20, 21), side(18, 9), side(17, 15)},
                                {0.4 + unit(random), 0.4 + unit(random), 0.7 + 2 * unit(random)},
                                round % 3 == 0 ? 0 : sign(random) * 3);
    Region region;
    for (std::size_t i = 0; i < 3; ++i) {
      region.low[i] = -25 * unit(random);
      region.high[i] = 25 * unit(random) + 1;
    }
    for (int plane = 0; plane < round % 4; ++plane) {
      region.planes.push_back({{5 * sign(random), 5 * sign(random), 5 * sign(random)},
                               {sign(random), sign(random), sign(random)}});
    }
    const auto cut = plan_cut(old.header, region);
    std::uint64_t kept = 0;
    std::array<std::uint32_t, 3> low = old.header.size, high{};
    for (std::uint32_t z = 0; z < old.header.size[2]; ++z) {
      for (std::uint32_t y = 0; y < old.header.size[1]; ++y) {
        for (std::uint32_t x = 0; x < old.header.size[0]; ++x) {
          if (!inside(region, world_of(old.header, {double(x), double(y), double(z)}))) continue;
          ++kept;
          const std::array<std::uint32_t, 3> index{x, y, z};
          for (std::size_t i = 0; i < 3; ++i) {
            low[i] = std::min(low[i], index[i]);
            high[i] = std::max(high[i], index[i] + 1);
          }
        }
      }
    }
    const bool enough = kept > 0 && high[0] - low[0] >= kLeastSide &&
                        high[1] - low[1] >= kLeastSide && high[2] - low[2] >= kLeastSide;
    ASSERT_EQ(cut.has_value(), enough) << round;
    if (!cut) continue;
    ++cuts;
    ASSERT_EQ(cut->kept, kept);
    ASSERT_EQ(cut->low, low);
    const auto left = cut_volume(old, region);
    ASSERT_TRUE(left.has_value());
    EXPECT_EQ(cut->air, -1000);
    std::uint64_t same = 0;
    for (std::uint32_t z = 0; z < cut->size[2]; ++z) {
      for (std::uint32_t y = 0; y < cut->size[1]; ++y) {
        for (std::uint32_t x = 0; x < cut->size[0]; ++x) {
          const std::array<double, 3> was{double(x + low[0]), double(y + low[1]),
                                          double(z + low[2])};
          const Vector world = world_of(old.header, was);
          const std::int16_t now = at(*left, x, y, z);
          if (!inside(region, world)) {
            ASSERT_EQ(now, cut->air);
            continue;
          }
          ASSERT_EQ(now, at(old, x + low[0], y + low[1], z + low[2]));
          ++same;
          // The voxel's old world position minus the shift is its new one.
          const Vector moved = world_of(left->header, {double(x), double(y), double(z)});
          for (std::size_t i = 0; i < 3; ++i) ASSERT_NEAR(world[i] - cut->shift[i], moved[i], 1e-9);
        }
      }
    }
    EXPECT_EQ(same, kept);
  }
  EXPECT_GT(cuts, 20);
}

TEST(Region, FullRegionKeepsVolumeUnchanged) {
  const Volume old = numbered({12, 11, 10}, {1, 1, 2});
  const auto left = cut_volume(old, {{-50, -50, -50}, {50, 50, 50}, {}});
  ASSERT_TRUE(left.has_value());
  EXPECT_EQ(left->voxels, old.voxels);
  EXPECT_EQ(left->header.size, old.header.size);
  EXPECT_EQ(left->header.maximum, old.header.maximum);
  EXPECT_EQ(left->header.repairs, old.header.repairs);
  EXPECT_EQ(left->header.window_width, old.header.window_width);
}

TEST(Region, RemovedValuesAreNeitherInVoxelsNorInTheirRange) {
  Volume old = numbered({16, 16, 16}, {1, 1, 1});
  old.voxels[old.voxels.size() - 1] = 32000;  // a gold tooth in the far corner
  measure(old);
  const auto left = cut_volume(old, {{-8, -8, -8}, {2, 8, 8}, {}});
  ASSERT_TRUE(left.has_value());
  EXPECT_EQ(std::count(left->voxels.begin(), left->voxels.end(), 32000), 0);
  EXPECT_LT(left->header.maximum, 32000);
  EXPECT_EQ(left->header.size, (std::array<std::uint32_t, 3>{10, 16, 16}));
}

TEST(Region, AirIsTheMinimumUnlessCtReachesMinus1000) {
  Volume old = numbered({16, 16, 16}, {1, 1, 1});
  old.header.modality = Modality::kMr;
  EXPECT_EQ(plan_cut(old.header, {{-8, -8, -8}, {8, 8, 8}, {}})->air, old.header.minimum);
  old.header.modality = Modality::kCt;
  old.header.minimum = -500;
  EXPECT_EQ(plan_cut(old.header, {{-8, -8, -8}, {8, 8, 8}, {}})->air, -500);
}

TEST(Region, RefusesRegionThatKeepsTooLittle) {
  const Volume old = numbered({16, 16, 16}, {1, 1, 1});
  EXPECT_FALSE(plan_cut(old.header, {{20, 20, 20}, {30, 30, 30}, {}}));
  EXPECT_FALSE(plan_cut(old.header, {{-8, -8, 0}, {8, 8, 3}, {}}));
  EXPECT_FALSE(plan_cut(old.header, {{-8, -8, -8}, {8, 8, 8}, {{{0, 0, -20}, {0, 0, 1}}}}));
  EXPECT_TRUE(plan_cut(old.header, {{-8, -8, -8}, {8, 8, 8}, {{{0, 0, 20}, {0, 0, 1}}}}));
}

TEST(Region, RoundTripsThroughJson) {
  const Region region{{-1, -2.5, -3}, {1, 2, 3}, {{{0, 1, 0}, {0, -0.6, -0.8}}}};
  const auto again = region_from_json(to_json(region));
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->low, region.low);
  EXPECT_EQ(again->high, region.high);
  ASSERT_EQ(again->planes.size(), 1U);
  EXPECT_EQ(again->planes[0].normal, region.planes[0].normal);
  EXPECT_TRUE(region_from_json(R"({"box": {"low": [0, 0, 0], "high": [1, 1, 1]}})"));
}

TEST(Region, NamesTheInvalidField) {
  const std::string box = R"("box": {"low": [0, 0, 0], "high": [1, 1, 1]})";
  const std::pair<std::string, std::string> cases[] = {
      {"", "keep"},
      {"[]", "keep"},
      {"{" + box + R"(, "name": 1})", "keep"},
      {R"({"box": 3})", "keep.box"},
      {R"({"box": {"low": [0, 0], "high": [1, 1, 1]}})", "keep.box.low"},
      {R"({"box": {"low": [0, 0, 1e300], "high": [1, 1, 1]}})", "keep.box.low"},
      {R"({"box": {"low": [0, 0, 0], "high": [1, "1", 1]}})", "keep.box.high"},
      {R"({"box": {"low": [0, 2, 0], "high": [1, 1, 1]}})", "keep.box"},
      {"{" + box + R"(, "planes": {}})", "keep.planes"},
      {"{" + box + R"(, "planes": [1]})", "keep.planes"},
      {"{" + box + R"(, "planes": [{"point": [0, 0, 0], "normal": [0, 0, 0]}]})", "keep.planes"},
      {"{" + box + R"(, "planes": [{"point": [0, 0, 0]}]})", "keep.planes"}};
  for (const auto& [text, field] : cases) {
    const auto read = region_from_json(text);
    ASSERT_FALSE(read.has_value()) << text;
    EXPECT_EQ(read.error().field, field) << text;
  }
}

TEST(Region, CutsEveryPhaseInTheSameWay) {
  Volume both = numbered({20, 19, 18}, {1, 1, 1});
  Volume second = both;
  std::reverse(second.voxels.begin(), second.voxels.end());
  const Volume first = both;
  both.header.phases = {{PhaseKind::kTime, 0}, {PhaseKind::kTime, 40}};
  both.voxels.insert(both.voxels.end(), second.voxels.begin(), second.voxels.end());
  const Region region{{-9, -9, -8}, {9, 8, 9}, {{{0, 0, 6}, {0.2, 0, 1}}}};
  const auto cut = cut_volume(both, region);
  ASSERT_TRUE(cut.has_value()) << cut.error().message;
  EXPECT_EQ(cut->header.phases, both.header.phases);
  std::vector<std::int16_t> expected = cut_volume(first, region)->voxels;
  const std::vector<std::int16_t> other = cut_volume(second, region)->voxels;
  EXPECT_NE(expected, other);
  expected.insert(expected.end(), other.begin(), other.end());
  EXPECT_EQ(cut->voxels, expected);
}

}  // namespace
}  // namespace diaphane::volume
