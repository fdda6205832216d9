#include "volume/oblique.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "volume/slices.h"

// tests/integration/test_oblique_slices.py compares a worker's slices with SciPy.

namespace diaphane::volume {
namespace {

/// A header with unequal spacing whose axes lie obliquely to the patient's.
Header oblique_header() {
  Header header;
  header.size = {14, 11, 9};
  header.spacing = {0.7, 1.1, 2.3};
  header.direction = {0.8, -0.36, 0.48, 0.6, 0.48, -0.64, 0, 0.8, 0.6};
  return header;
}

Vector centre_of(const Header& header, std::array<std::uint32_t, 3> voxel) {
  Vector world{};
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t a = 0; a < 3; ++a) {
      world[k] +=
          header.direction[3 * k + a] * (voxel[a] + 0.5 - header.size[a] / 2.0) * header.spacing[a];
    }
  }
  return world;
}

template <typename Value>
Volume filled(const Header& header, const Value& value) {
  Volume volume;
  volume.header = header;
  for (std::uint32_t z = 0; z < header.size[2]; ++z) {
    for (std::uint32_t y = 0; y < header.size[1]; ++y) {
      for (std::uint32_t x = 0; x < header.size[0]; ++x) {
        volume.voxels.push_back(static_cast<std::int16_t>(std::lround(value(x, y, z))));
      }
    }
  }
  measure(volume);
  return volume;
}

/// A slice through the centre, oblique to the patient and to the voxels.
ObliqueSlice tilted(std::uint32_t side = 5, double mm = 0.5) {
  const Vector right{2.0 / 3, 2.0 / 3, 1.0 / 3}, down{-2.0 / 3, 1.0 / 3, 2.0 / 3};
  ObliqueSlice slice;
  slice.columns = slice.rows = side;
  for (std::size_t k = 0; k < 3; ++k) {
    slice.right[k] = mm * right[k];
    slice.down[k] = mm * down[k];
    slice.first[k] = -(side - 1.0) / 2 * (slice.right[k] + slice.down[k]);
  }
  return slice;
}

Vector place_of(const ObliqueSlice& slice, std::size_t pixel) {
  const std::size_t column = pixel % slice.columns, row = pixel / slice.columns;
  Vector place{};
  for (std::size_t k = 0; k < 3; ++k) {
    place[k] = slice.first[k] + double(column) * slice.right[k] + double(row) * slice.down[k];
  }
  return place;
}

double ramp(const Vector& place) { return 400 * place[0] - 700 * place[1] + 300 * place[2]; }

TEST(Oblique, InterpolatesALinearFieldExactly) {
  const Header header = oblique_header();
  const Volume volume =
      filled(header, [&](auto... at) { return ramp(centre_of(header, {at...})); });
  ObliqueSlice slice = tilted();
  for (const Projection projection : {Projection::kMean, Projection::kMaximum}) {
    for (const double thickness : {0.0, 1.5}) {
      slice.projection = projection;
      slice.thickness = thickness;
      ASSERT_TRUE(check(header, slice));
      const auto values = sample(volume, slice);
      ASSERT_EQ(values.size(), 25u);
      const Vector normal = normal_of(slice);
      const double slope = std::abs(ramp(normal));
      const double shift = projection == Projection::kMaximum ? slope * thickness / 2 : 0;
      for (std::size_t i = 0; i < values.size(); ++i) {
        // Voxels and the result are rounded by at most 0.5 each.
        EXPECT_NEAR(values[i], ramp(place_of(slice, i)) + shift, 1.0 + 1e-6) << i;
      }
    }
  }
}

TEST(Oblique, EqualsVoxelsAtTheirCentres) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> any(-32768, 32767);
  Header header = oblique_header();
  header.direction = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const Volume volume = filled(header, [&](auto...) { return any(random); });
  const SliceStack stack = plan_stack(header, Plane::kCoronal);
  ObliqueSlice slice;
  slice.columns = stack.columns;
  slice.rows = stack.rows;
  slice.right = stack.right;
  slice.down = stack.down;
  for (std::uint32_t index = 0; index < stack.slices; ++index) {
    for (std::size_t k = 0; k < 3; ++k) slice.first[k] = stack.first[k] + index * stack.next[k];
    EXPECT_EQ(sample(volume, slice), *slice_of(volume, stack, index)) << index;
  }
}

TEST(Oblique, ContinuesTheOutermostVoxelsToTheBorderAndEndsThere) {
  Header header = oblique_header();
  header.direction = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const Volume volume = filled(header, [](int x, int, int) { return 100 * x + 7; });
  ObliqueSlice slice;
  slice.columns = slice.rows = 1;
  slice.right = {1, 0, 0};
  slice.down = {0, 1, 0};
  const double border = header.size[0] * header.spacing[0] / 2;
  for (const auto& [x, value] : {std::pair{border - 0.01, 1307}, {border + 0.01, 7}}) {
    slice.first = {x, 0, 0};
    EXPECT_EQ(sample(volume, slice).front(), value) << x;
  }
  // A slab leaves out what lies outside.
  slice.right = {0, 1, 0};
  slice.down = {0, 0, 1};
  slice.first = {border, 0, 0};
  slice.thickness = 0.1;
  EXPECT_EQ(sample(volume, slice).front(), 1307);
}

TEST(Oblique, HiddenVoxelsContributeToNoSample) {
  const Header header = oblique_header();
  constexpr int kSecret = 30000;
  const Region::Plane side{{0.2, 0, 0}, {1, 0.5, 0.25}};
  const std::array sides{side};
  const KeptVoxels kept(header, sides);
  const Volume volume = filled(header, [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return kept.keeps(x, y, z) ? 0 : kSecret;
  });
  ObliqueSlice slice = tilted(41, 0.3);
  for (const Projection projection :
       {Projection::kMean, Projection::kMaximum, Projection::kMinimum}) {
    for (const double thickness : {0.0, 3.0}) {
      slice.projection = projection;
      slice.thickness = thickness;
      const auto values = sample_clipped(volume, slice, kept);
      const auto shown = std::count(values.begin(), values.end(), 0);
      const auto blank = std::count(values.begin(), values.end(), kBlank);
      EXPECT_GT(shown, 50);
      EXPECT_GT(blank, 50);
      EXPECT_EQ(shown + blank, 41 * 41);
    }
  }
}

TEST(Oblique, RefusesInvalidSlicesAndTooMuchWork) {
  const Header header = oblique_header();
  ASSERT_TRUE(check(header, tilted()));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](const auto& change) {
    ObliqueSlice slice = tilted();
    change(slice);
    const auto checked = check(header, slice);
    return checked ? std::string("nothing") : checked.error().field;
  };
  EXPECT_EQ(refused([&](auto& s) { s.first[1] = nan; }), "first");
  EXPECT_EQ(refused([&](auto& s) { s.right = {}; }), "right");
  EXPECT_EQ(refused([&](auto& s) { s.right[2] = nan; }), "right");
  EXPECT_EQ(refused([&](auto& s) { s.down[0] = 1e9; }), "down");
  EXPECT_EQ(refused([&](auto& s) { s.down = s.right; }), "down");
  EXPECT_EQ(refused([&](auto& s) { s.columns = 0; }), "columns");
  EXPECT_EQ(refused([&](auto& s) { s.rows = kMostObliqueSide + 1; }), "rows");
  EXPECT_EQ(refused([&](auto& s) { s.thickness = -1; }), "thickness");
  EXPECT_EQ(refused([&](auto& s) { s.thickness = nan; }), "thickness");
  EXPECT_EQ(refused([&](auto& s) { s.thickness = 1e300; }), "thickness");
  EXPECT_EQ(refused([&](auto& s) {
              s.columns = s.rows = kMostObliqueSide;
              s.thickness = 10;
            }),
            "thickness");
}

TEST(Oblique, SamplesOfASlabAreAtMostTheSmallestSpacingApart) {
  const Header header = oblique_header();
  EXPECT_EQ(layers_of(header, 0), 1u);
  EXPECT_EQ(layers_of(header, 0.1), 2u);
  EXPECT_EQ(layers_of(header, 7), 11u);
  EXPECT_EQ(layers_of(header, 7.1), 12u);
}

}  // namespace
}  // namespace diaphane::volume
