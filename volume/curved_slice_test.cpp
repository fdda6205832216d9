#include "volume/curved_slice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

// tests/integration/test_curved_slices.py compares a worker's slices with SciPy.

namespace diaphane::volume {
namespace {

/// A header with unequal spacing whose axes lie obliquely to the patient's.
Header oblique_header() {
  Header header;
  header.size = {40, 30, 20};
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

CurvedSlice bent() {
  CurvedSlice slice;
  slice.points = {{-6, -4, -3}, {-1, 3, -1}, {4, 1, 3}, {7, 4, 6}};
  slice.pixel = 0.5;
  slice.columns = 35;
  slice.rows = 9;
  slice.angle = 33;
  return slice;
}

double ramp(const Vector& place) { return 400 * place[0] - 700 * place[1] + 300 * place[2]; }

/// Returns the place of a pixel from the frame of the curve, without columns_of().
Vector place_of(const CurvedSlice& slice, const Curve& curve, std::size_t column, std::size_t row,
                double through = 0) {
  const Curve::Frame frame = curve.at(double(column) * slice.pixel);
  const double angle = slice.angle / 45 * std::atan(1.0);
  const double across = (double(row) - (slice.rows - 1.0) / 2) * slice.pixel;
  // In the plane of `across` and its right-handed neighbour.
  const double one = across * std::cos(angle) - through * std::sin(angle);
  const double other = across * std::sin(angle) + through * std::cos(angle);
  Vector place = frame.place;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    const double third = frame.along[i] * frame.across[j] - frame.along[j] * frame.across[i];
    place[k] += one * frame.across[k] + other * third;
  }
  return place;
}

TEST(CurvedSlice, InterpolatesALinearFieldExactly) {
  const Header header = oblique_header();
  const Volume volume =
      filled(header, [&](auto... at) { return ramp(centre_of(header, {at...})); });
  CurvedSlice slice = bent();
  const Curve curve = *Curve::through(slice.points);
  for (const Projection projection :
       {Projection::kMean, Projection::kMaximum, Projection::kMinimum}) {
    for (const double thickness : {0.0, 1.5}) {
      slice.projection = projection;
      slice.thickness = thickness;
      ASSERT_TRUE(check(header, slice));
      const auto values = sample(volume, slice);
      ASSERT_EQ(values.size(), 35u * 9);
      for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t column = i % slice.columns, row = i / slice.columns;
        const double faces[]{ramp(place_of(slice, curve, column, row, thickness / 2)),
                             ramp(place_of(slice, curve, column, row, -thickness / 2))};
        const double expected = projection == Projection::kMean      ? (faces[0] + faces[1]) / 2
                                : projection == Projection::kMaximum ? std::max(faces[0], faces[1])
                                                                     : std::min(faces[0], faces[1]);
        // Voxels and the result are rounded by at most 0.5 each.
        EXPECT_NEAR(values[i], expected, 1.0 + 1e-6) << i;
      }
    }
  }
}

TEST(CurvedSlice, AlongALineEqualsAnObliqueSlice) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> any(-32768, 32767);
  const Volume volume = filled(oblique_header(), [&](auto...) { return any(random); });
  CurvedSlice slice;
  // A pixel is a node of the curve, so that rounding does not move it.
  slice.points = {{-8, 1, 2}, {8, 1, 2}};
  slice.pixel = 0.25;
  slice.columns = 65;
  slice.rows = 21;
  ObliqueSlice plane;
  plane.columns = 65;
  plane.rows = 21;
  plane.first = {-8, 1, 2 + 2.5};
  plane.right = {0.25, 0, 0};
  plane.down = {0, 0, -0.25};
  for (const double thickness : {0.0, 2.0}) {
    slice.thickness = plane.thickness = thickness;
    slice.projection = plane.projection = Projection::kMaximum;
    const auto curved = sample(volume, slice), flat = sample(volume, plane);
    ASSERT_EQ(curved.size(), flat.size());
    for (std::size_t i = 0; i < flat.size(); ++i) EXPECT_NEAR(curved[i], flat[i], 1) << i;
  }
}

TEST(CurvedSlice, AQuarterTurnShowsTheOtherDirection) {
  const Header header = oblique_header();
  const Volume volume =
      filled(header, [&](auto... at) { return 100 * centre_of(header, {at...})[1]; });
  CurvedSlice slice;
  slice.points = {{-3, 0, 0}, {3, 0, 0}};
  slice.pixel = 1;
  slice.columns = 7;
  slice.rows = 3;
  // Rows lead to the feet, and a quarter of a turn later to the back.
  EXPECT_NEAR(sample(volume, slice)[0], 0, 1);
  slice.angle = 90;
  const auto values = sample(volume, slice);
  EXPECT_NEAR(values[0], -100, 1);
  EXPECT_NEAR(values[7], 0, 1);
  EXPECT_NEAR(values[14], 100, 1);
}

TEST(CurvedSlice, HiddenVoxelsContributeToNoSample) {
  const Header header = oblique_header();
  constexpr int kSecret = 30000;
  const Region::Plane side{{0.2, 0, 0}, {1, 0.5, 0.25}};
  const std::array sides{side};
  const KeptVoxels kept(header, sides);
  const Volume volume = filled(header, [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return kept.keeps(x, y, z) ? 0 : kSecret;
  });
  CurvedSlice slice = bent();
  for (const double thickness : {0.0, 3.0}) {
    slice.projection = Projection::kMaximum;
    slice.thickness = thickness;
    const auto values = sample_clipped(volume, slice, kept);
    const auto shown = std::count(values.begin(), values.end(), 0);
    const auto blank = std::count(values.begin(), values.end(), kBlank);
    EXPECT_GT(shown, 50);
    EXPECT_GT(blank, 50);
    EXPECT_EQ(shown + blank, 35 * 9);
  }
}

TEST(CurvedSlice, LabelsAndSecondScanLieAtTheSamePixels) {
  const Header header = oblique_header();
  Volume volume = filled(header, [](auto...) { return 0; });
  volume.label_set.table = {{3, "Lung", {}}};
  volume.label_set.labels = {header.size, std::vector<std::uint8_t>(volume.voxels.size(), 0)};
  const Volume second = filled(header, [&](auto... at) {
    const bool front = centre_of(header, {at...})[1] < 0;
    const std::array<std::uint32_t, 3> voxel{at...};
    volume.label_set.labels
        .voxels[voxel[0] + header.size[0] * (voxel[1] + std::size_t{header.size[1]} * voxel[2])] =
        front ? 1 : 0;
    return ramp(centre_of(header, {at...}));
  });
  const CurvedSlice slice = bent();
  const auto values = sample(volume, slice);
  const auto labels = labels_of_slice(volume, slice);

  const auto other = second_slice(header, slice, second, kIdentity, values);
  const auto own = sample(second, slice);
  const Curve curve = *Curve::through(slice.points);
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(other[i], own[i], 1) << i;
    const double y = place_of(slice, curve, i % slice.columns, i / slice.columns)[1];
    // The label is that of the voxel, whose centre may lie this much further.
    if (std::abs(y) > 2) EXPECT_EQ(labels[i], y < 0 ? 1 : 0) << i;
  }
  const Region::Plane side{{0, 0, 0}, {0, 0, 1}};
  const std::array sides{side};
  const KeptVoxels kept(header, sides);
  const auto clipped = sample_clipped(volume, slice, kept);
  const auto shown = labels_of_slice(volume, slice, nullptr);
  const ClippedSlice part{kept, clipped};
  const auto partly = labels_of_slice(volume, slice, &part);
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(partly[i], clipped[i] == kBlank ? 0 : shown[i]) << i;
  }
}

TEST(CurvedSlice, CountsTheColumnsOfAWholeCurve) {
  const std::vector<Vector> points{{0, 0, 0}, {10, 0, 0}};
  EXPECT_EQ(columns_along(points, 0.1), 101u);
  EXPECT_EQ(columns_along(points, 3), 4u);
  EXPECT_EQ(columns_along(points, 0.001), 0u) << "too many";
  EXPECT_EQ(columns_along(points, 0), 0u);
  EXPECT_EQ(columns_along({{1, 1, 1}}, 1), 0u);
}

TEST(CurvedSlice, RefusesInvalidSlicesAndTooMuchWork) {
  const Header header = oblique_header();
  ASSERT_TRUE(check(header, bent()));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](const auto& change) {
    CurvedSlice slice = bent();
    change(slice);
    const auto checked = check(header, slice);
    return checked ? std::string("nothing") : checked.error().field;
  };
  EXPECT_EQ(refused([&](auto& s) { s.points = {}; }), "points");
  EXPECT_EQ(refused([&](auto& s) { s.points = {{1, 1, 1}}; }), "points");
  EXPECT_EQ(refused([&](auto& s) { s.points[1][2] = nan; }), "points");
  EXPECT_EQ(refused([&](auto& s) { s.points.resize(kMostCurvePoints + 1); }), "points");
  EXPECT_EQ(refused([&](auto& s) { s.pixel = 0; }), "pixel");
  EXPECT_EQ(refused([&](auto& s) { s.pixel = -1; }), "pixel");
  EXPECT_EQ(refused([&](auto& s) { s.pixel = nan; }), "pixel");
  EXPECT_EQ(refused([&](auto& s) { s.pixel = 1e-9; }), "pixel");
  EXPECT_EQ(refused([&](auto& s) { s.pixel = 1e9; }), "pixel");
  EXPECT_EQ(refused([&](auto& s) { s.angle = nan; }), "angle");
  EXPECT_EQ(refused([&](auto& s) { s.columns = 0; }), "columns");
  EXPECT_EQ(refused([&](auto& s) { s.columns = 200; }), "columns") << "longer than the curve";
  EXPECT_EQ(refused([&](auto& s) {
              s.pixel = 0.001;
              s.columns = kMostObliqueSide + 1;
            }),
            "columns");
  EXPECT_EQ(refused([&](auto& s) { s.rows = 0; }), "rows");
  EXPECT_EQ(refused([&](auto& s) { s.rows = kMostObliqueSide + 1; }), "rows");
  EXPECT_EQ(refused([&](auto& s) { s.thickness = -1; }), "thickness");
  EXPECT_EQ(refused([&](auto& s) { s.thickness = nan; }), "thickness");
  EXPECT_EQ(refused([&](auto& s) { s.thickness = 1e300; }), "thickness");
  EXPECT_EQ(refused([&](auto& s) {
              s.pixel = 0.005;
              s.columns = s.rows = kMostObliqueSide;
              s.thickness = 10;
            }),
            "thickness");
}

}  // namespace
}  // namespace diaphane::volume
