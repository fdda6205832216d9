#include "renderd/kernel/medium.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "renderd/math/random.h"

namespace diaphane::render {
namespace {

std::vector<std::int16_t> noise(Int3 size, std::int32_t low, std::int32_t high) {
  std::vector<std::int16_t> v(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
                              static_cast<std::size_t>(size.z));
  Random random(9, 9, 9);
  for (auto& x : v) {
    x = static_cast<std::int16_t>(
        low + static_cast<std::int32_t>(random.one() * static_cast<float>(high - low)));
  }
  return v;
}

/// Trilinear interpolation by its definition, in double precision.
double reference(const std::vector<std::int16_t>& voxels, Int3 size, Double3 p) {
  double sum = 0;
  const double q[] = {p.x - 0.5, p.y - 0.5, p.z - 0.5};
  const int n[] = {size.x, size.y, size.z};
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    int index[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double floor = std::floor(q[axis]);
      const int up = corner >> axis & 1;
      weight *= up != 0 ? q[axis] - floor : 1 - (q[axis] - floor);
      index[axis] = std::clamp(static_cast<int>(floor) + up, 0, n[axis] - 1);
    }
    sum += weight *
           voxels[static_cast<std::size_t>(index[0] + size.x * (index[1] + size.y * index[2]))];
  }
  return sum;
}

TEST(LinearVolume, InterpolatesAndClampsLikeTheDefinition) {
  const Int3 sizes[] = {{7, 5, 9}, {1, 1, 1}, {1, 6, 3}, {4, 1, 1}, {2, 2, 2}};
  for (const Int3 size : sizes) {
    const auto voxels = noise(size, -32768, 32767);
    const LinearVolume volume{voxels.data(), size};
    Random random(1, 2, 3);
    for (int i = 0; i < 20'000; ++i) {
      const Random::Pair a = random.two(), b = random.two();
      // Places are also slightly outside, where rounding can put them.
      const Float3 p{(a.a * 1.1f - 0.05f) * static_cast<float>(size.x),
                     (a.b * 1.1f - 0.05f) * static_cast<float>(size.y),
                     (b.a * 1.1f - 0.05f) * static_cast<float>(size.z)};
      ASSERT_NEAR(volume.at(p), reference(voxels, size, to_double(p)), 0.2) << size.x;
    }
  }
}

TEST(LinearVolume, ReturnsTheVoxelAtItsCentre) {
  const Int3 size{3, 4, 5};
  const auto voxels = noise(size, -1000, 3000);
  const LinearVolume volume{voxels.data(), size};
  EXPECT_EQ(volume.at({1.5f, 2.5f, 3.5f}), voxels[1 + 3 * (2 + 4 * 3)]);
  EXPECT_EQ(volume.at({0.0f, 0.0f, 0.0f}), voxels[0]);
  EXPECT_EQ(volume.at({3.0f, 4.0f, 5.0f}), voxels.back());
}

TEST(TransferTables, ColourIsWeightedByOpacityWithoutDarkEdges) {
  const float extinction[] = {0, 2, 4};
  const Float4 colour[] = {{0, 0, 0, 0}, {0.8f, 0.4f, 0.2f, 1}, {0.8f, 0.4f, 0.2f, 1}};
  const TransferView t{extinction, colour, 1, -10, 0, 3};  // values 10, 11, 12
  EXPECT_FLOAT_EQ(extinction_at(t, 10.5f), 1);
  EXPECT_FLOAT_EQ(extinction_at(t, 11.5f), 3);
  EXPECT_FLOAT_EQ(extinction_at(t, -1e6f), 0);
  EXPECT_FLOAT_EQ(extinction_at(t, 1e6f), 4);
  EXPECT_FLOAT_EQ(albedo_at(t, 10.25f).x, 0.8f) << "a quarter of the weight, but the full colour";
  EXPECT_EQ(albedo_at(t, 10).x, 0);
}

}  // namespace
}  // namespace diaphane::render
