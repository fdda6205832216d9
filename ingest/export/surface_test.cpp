#include "ingest/export/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "ingest/export/export_scan.h"

namespace diaphane::ingest {
namespace {

using Size = std::array<std::uint32_t, 3>;

template <typename Value>
volume::Volume filled(Size size, Value value) {
  volume::Volume volume;
  volume.header.size = size;
  volume.voxels.reserve(volume.header.voxel_count());
  for (std::uint32_t z = 0; z < size[2]; ++z) {
    for (std::uint32_t y = 0; y < size[1]; ++y) {
      for (std::uint32_t x = 0; x < size[0]; ++x)
        volume.voxels.push_back(static_cast<std::int16_t>(value(x, y, z)));
    }
  }
  volume::measure(volume);
  return volume;
}

/// Labels the voxels with a value above 0.
volume::Volume labelled(volume::Volume volume) {
  volume.label_set.table = {{7, "part", {200, 10, 10}}};
  volume.label_set.labels.size = volume.header.size;
  for (const std::int16_t value : volume.voxels)
    volume.label_set.labels.voxels.push_back(value > 0 ? 1 : 0);
  return volume;
}

double distance(std::uint32_t x, std::uint32_t y, std::uint32_t z, double centre) {
  return std::hypot(x - centre, y - centre, z - centre);
}

volume::Volume noise(unsigned seed) {
  std::mt19937 random(seed);
  return filled({24, 20, 18}, [&](auto, auto, auto) {
    return std::uniform_int_distribution<int>(-1000, 3000)(random);
  });
}

TEST(Surface, OfNoiseIsClosed) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const auto volume = noise(seed);
    for (const std::int16_t above : {-900, 0, 1500, 2900}) {
      const auto mesh = make_surface(volume, {0, above});
      ASSERT_TRUE(mesh) << mesh.error().message;
      EXPECT_TRUE(is_closed(*mesh));
      EXPECT_GT(enclosed_volume(*mesh), 0);
    }
  }
}

TEST(Surface, OfLabelWithContactsAtEdgesAndCornersIsClosed) {
  const auto mesh = make_surface(labelled(noise(3)), {1, 0});
  ASSERT_TRUE(mesh);
  EXPECT_TRUE(is_closed(*mesh));
  EXPECT_EQ(mesh->colour, (std::array<std::uint8_t, 3>{200, 10, 10}));
}

TEST(Surface, OfValuesFarApartHasNoEqualPoints) {
  // Voxels just inside, between extreme ones: the surface comes close to their centres.
  auto volume = filled({12, 12, 12}, [](auto x, auto y, auto z) {
    return (x + y + z) % 2 == 0 ? 300 : ((x * y + z) % 3 == 0 ? 32767 : -32768);
  });
  const auto near = make_surface(volume, {0, 300});
  volume.header.origin = {{900.5, -900.5, 1800.25}};
  const auto mesh = make_surface(volume, {0, 300});
  ASSERT_TRUE(mesh && near);
  EXPECT_TRUE(is_closed(*mesh));
  // A surface with equal points would have been replaced by that of a coarser grid.
  EXPECT_EQ(mesh->triangles.size(), near->triangles.size());
}

TEST(Surface, IsClosedWhereItLeavesTheScan) {
  const auto volume = labelled(filled({10, 11, 12}, [](auto, auto, auto) { return 5; }));
  for (const Inside& inside : {Inside{1, 0}, Inside{0, 5}}) {
    const auto mesh = make_surface(volume, inside);
    ASSERT_TRUE(mesh);
    EXPECT_TRUE(is_closed(*mesh));
  }
}

TEST(Surface, OfSphereHasVolumeOfItsLabel) {
  auto volume = labelled(filled({70, 70, 70}, [](auto x, auto y, auto z) {
    return distance(x, y, z, 34.3) <= 25 ? 100 : -100;
  }));
  volume.header.spacing = {0.5, 0.8, 1.5};
  const auto voxels =
      std::count(volume.label_set.labels.voxels.begin(), volume.label_set.labels.voxels.end(), 1);
  const double expected = static_cast<double>(voxels) * 0.5 * 0.8 * 1.5;
  const auto mesh = make_surface(volume, {1, 0});
  ASSERT_TRUE(mesh);
  EXPECT_NEAR(enclosed_volume(*mesh) / expected, 1, 0.01);
}

TEST(Surface, OfSmoothThresholdLiesBetweenVoxels) {
  // The value falls by 100 per voxel of distance, so the surface at 0 - 1/2 has the radius 20.
  const auto volume = filled({50, 50, 50}, [](auto x, auto y, auto z) {
    return std::lround(100 * (20 - distance(x, y, z, 24.6)));
  });
  const auto mesh = make_surface(volume, {0, 0});
  ASSERT_TRUE(mesh);
  const double centre = 24.6 - 24.5;  // the scan's centre is the origin
  for (const auto& point : mesh->points) {
    // The values are rounded to 1/200 of a voxel, interpolation along an edge of the grid is off by
    // at most 1/8 of the second derivative, 1/radius, and the values closest to the threshold are
    // moved to 1/1500 of the largest difference, 2300.
    const double tolerance = 1.0 / 200 + 1.0 / 8 / 20 + 2300.0 / 1500 / 100;
    EXPECT_NEAR(std::hypot(point[0] - centre, point[1] - centre, point[2] - centre), 20.005,
                tolerance);
  }
}

TEST(Surface, OfTooManyTrianglesIsReducedAndClosed) {
  const auto volume = labelled(filled({60, 60, 60}, [](auto x, auto y, auto z) {
    return distance(x, y, z, 29.5) <= 24 ? 100 : -100;
  }));
  const auto whole = make_surface(volume, {1, 0});
  ASSERT_TRUE(whole);
  SurfaceLimits limits;
  limits.triangles = whole->triangles.size() / 5;
  const auto reduced = make_surface(volume, {1, 0}, limits);
  ASSERT_TRUE(reduced);
  EXPECT_LE(reduced->triangles.size(), limits.triangles);
  EXPECT_GE(reduced->triangles.size(), limits.triangles / 2);
  EXPECT_TRUE(is_closed(*reduced));
  EXPECT_NEAR(enclosed_volume(*reduced) / enclosed_volume(*whole), 1, 0.01);
}

TEST(Surface, UsesCoarserGridForMoreSamplesThanAllowed) {
  const auto volume = labelled(filled({60, 60, 60}, [](auto x, auto y, auto z) {
    return distance(x, y, z, 29.5) <= 24 ? 100 : -100;
  }));
  SurfaceLimits limits;
  limits.samples = 30 * 30 * 30;
  const auto mesh = make_surface(volume, {1, 0}, limits);
  ASSERT_TRUE(mesh);
  EXPECT_TRUE(is_closed(*mesh));
  const double sphere = 4.0 / 3 * 3.14159265 * 24 * 24 * 24;
  EXPECT_NEAR(enclosed_volume(*mesh) / sphere, 1, 0.03);  // 2 voxels per sample at radius 24
}

TEST(Field, CountsThePointsOfItsSurface) {
  const auto volume = noise(1);
  const auto field = sample_field(volume, {0, 1500}, 1, 1'000'000);
  ASSERT_TRUE(field);
  const auto mesh = make_surface(volume, {0, 1500});
  ASSERT_TRUE(mesh);
  EXPECT_EQ(crossings(*field), mesh->points.size());
}

TEST(Surface, NeedsAVoxelInside) {
  auto volume = filled({9, 9, 9}, [](auto x, auto, auto) { return x; });
  EXPECT_EQ(make_surface(volume, {0, 9}).error().code, ErrorCode::kInvalid);
  volume.label_set.table = {{1, "empty", {}}};
  volume.label_set.labels = {volume.header.size,
                             std::vector<std::uint8_t>(volume.header.voxel_count())};
  EXPECT_EQ(make_surface(volume, {1, 0}).error().code, ErrorCode::kInvalid);
}

TEST(Mesh, WithMissingTriangleIsOpen) {
  auto mesh = *make_surface(filled({9, 9, 9}, [](auto x, auto, auto) { return x; }), {0, 4});
  ASSERT_TRUE(is_closed(mesh));
  auto turned = mesh;
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_FALSE(is_closed(turned));
  auto equal = mesh;
  equal.points[1] = equal.points[0];
  EXPECT_FALSE(is_closed(equal));
  mesh.triangles.pop_back();
  EXPECT_FALSE(is_closed(mesh));
}

TEST(ExportScan, RefusesWrongOrders) {
  const auto volume = labelled(filled({9, 9, 9}, [](auto x, auto, auto) { return x; }));
  const auto refusal = [&](ExportOrder order) {
    const auto done =
        export_scan(volume, order, {}, [](std::string_view) -> Result<void> { return {}; });
    return done ? std::string() : done.error().message;
  };
  EXPECT_EQ(refusal({ExportFormat::kStl, 7, {}}), "");
  EXPECT_EQ(refusal({ExportFormat::kGlb, {}, 3}), "");
  EXPECT_EQ(refusal({ExportFormat::kGlb, {}, -100000}), "");
  EXPECT_EQ(refusal({ExportFormat::kNifti, {}, {}}), "");
  EXPECT_EQ(refusal({ExportFormat::kStl, 1, {}}), "the scan has no such label");
  EXPECT_EQ(refusal({ExportFormat::kStl, {}, 100000}), "no voxel has a value this high");
  EXPECT_EQ(refusal({ExportFormat::kStl, {}, {}}), "a surface needs either a label or a threshold");
  EXPECT_EQ(refusal({ExportFormat::kStl, 7, 3}), "a surface needs either a label or a threshold");
  EXPECT_NE(refusal({ExportFormat::kNifti, 7, {}}), "");
}

}  // namespace
}  // namespace diaphane::ingest
