#include "ingest/registration/register.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace diaphane::ingest {
namespace {

using volume::Matrix;

/// A turn about an axis through the origin by `degrees`, and a shift.
Matrix motion(std::array<double, 3> axis, double degrees, std::array<double, 3> shift) {
  const double norm = std::hypot(axis[0], axis[1], axis[2]);
  const double a = degrees * std::numbers::pi / 180, c = std::cos(a), s = std::sin(a), t = 1 - c;
  const double x = axis[0] / norm, y = axis[1] / norm, z = axis[2] / norm;
  return {t * x * x + c,
          t * x * y - s * z,
          t * x * z + s * y,
          shift[0],
          t * x * y + s * z,
          t * y * y + c,
          t * y * z - s * x,
          shift[1],
          t * x * z - s * y,
          t * y * z + s * x,
          t * z * z + c,
          shift[2],
          0,
          0,
          0,
          1};
}

/// What lies at a place of a head, from 0 (air) on. It has no symmetry.
int tissue(double x, double y, double z) {
  const auto inside = [&](double cx, double cy, double cz, double a, double b, double c) {
    return std::pow((x - cx) / a, 2) + std::pow((y - cy) / b, 2) + std::pow((z - cz) / c, 2) < 1;
  };
  if (inside(0, -78, -8, 8, 14, 12)) return 1;  // the nose
  if (!inside(0, 0, 0, 65, 80, 75)) return 0;
  if (!inside(0, 0, 0, 59, 74, 69)) return 1;
  if (!inside(0, 2, 4, 53, 68, 62)) return 2;
  if (inside(-12, 5, 12, 7, 22, 9) || inside(14, 8, 14, 6, 18, 8)) return 3;
  if (inside(20, -25, 25, 11, 11, 11)) return 4;
  return std::sin(0.16 * x + 0.05 * y) * std::sin(0.13 * y) * std::cos(0.15 * z) > 0.2 ? 5 : 6;
}

/// Scans the head after `motion`, which maps places of the head to those of the scan. `values` are
/// those of the tissues.
CoarseScan scan(const Matrix& motion, const std::array<double, 7>& values, double noise = 0,
                std::array<double, 3> low = {-90, -105, -95},
                std::array<double, 3> high = {90, 100, 95}, double spacing = 3) {
  CoarseScan out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.size[i] = static_cast<std::uint32_t>((high[i] - low[i]) / spacing);
    out.spacing[i] = spacing;
  }
  out.direction = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  out.origin = low;
  const Matrix back = volume::inverse_of_rigid(motion);
  std::mt19937 random(static_cast<unsigned>(1000 + values[1] + 10 * motion[3]));
  std::normal_distribution<double> grain(0, noise);
  for (std::uint32_t z = 0; z < out.size[2]; ++z) {
    for (std::uint32_t y = 0; y < out.size[1]; ++y) {
      for (std::uint32_t x = 0; x < out.size[0]; ++x) {
        double sum = 0;  // of eight places in the voxel
        for (int corner = 0; corner < 8; ++corner) {
          const auto p = volume::moved(back, out.point({x + 0.25 * (1 - 2 * (corner & 1)),
                                                        y + 0.25 * (1 - 2 * (corner >> 1 & 1)),
                                                        z + 0.25 * (1 - 2 * (corner >> 2))}));
          sum += values[static_cast<std::size_t>(tissue(p[0], p[1], p[2]))];
        }
        out.values.push_back(static_cast<float>(sum / 8 + grain(random)));
      }
    }
  }
  return out;
}

constexpr std::array<double, 7> kCt{-1000, 20, 900, 5, 60, 34, 42};
constexpr std::array<double, 7> kMr{0, 300, 30, 60, 520, 330, 430};

constexpr double kHalfVoxel = 1.5;  // mm

/// Returns the largest distance between two motions of places of the head, mm. They map them to the
/// moving scan, because the other way would compare places that may be far from the head.
double furthest(const Matrix& a, const Matrix& b) {
  double most = 0;
  for (int i = 0; i < 200; ++i) {
    const double z = -1 + 2 * (i + 0.5) / 200, r = std::sqrt(1 - z * z), t = 2.4 * i;
    const std::array<double, 3> p{75 * r * std::cos(t), 75 * r * std::sin(t), 75 * z};
    const auto u = volume::moved(a, p), v = volume::moved(b, p);
    most = std::max(most, std::hypot(u[0] - v[0], u[1] - v[1], u[2] - v[2]));
  }
  return most;
}

TEST(Registration, FindsAMotionBetweenCtAndMr) {
  const Matrix moved = motion({1, 2, -1}, 12, {9, -14, 6});
  const CoarseScan fixed = scan(volume::kIdentity, kCt, 12);
  const CoarseScan moving = scan(moved, kMr, 12);
  const auto found = register_rigid(fixed, moving);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_LT(furthest(volume::inverse_of_rigid(found->to_fixed), moved), kHalfVoxel);
  EXPECT_LT(found->residual_mm, 1.0);
  EXPECT_GT(found->residual_mm, 0);
  EXPECT_GT(found->overlap, 0.7);
  EXPECT_GT(found->information, found->information_before);
  EXPECT_TRUE(volume::rigid_motion(found->to_fixed));
}

TEST(Registration, FindsScansThatLieFarApartAndAreTilted) {
  const Matrix moved = motion({1, 0, 0.2}, 32, {400, -250, 900});
  std::array<double, 3> low{310, -355, 800}, high{490, -145, 995};
  const auto found =
      register_rigid(scan(volume::kIdentity, kMr, 8), scan(moved, kMr, 8, low, high));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_LT(furthest(volume::inverse_of_rigid(found->to_fixed), moved), kHalfVoxel);
}

TEST(Registration, SameArgumentsGiveTheSameResult) {
  const CoarseScan fixed = scan(volume::kIdentity, kCt, 5, {-90, -105, -95}, {90, 100, 95}, 5);
  const CoarseScan moving =
      scan(motion({0, 0, 1}, 5, {3, 0, 0}), kMr, 5, {-90, -105, -95}, {90, 100, 95}, 5);
  const auto one = register_rigid(fixed, moving), two = register_rigid(fixed, moving);
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->to_fixed, two->to_fixed);
  EXPECT_EQ(one->residual_mm, two->residual_mm);
}

TEST(Registration, ResidualCoversTheErrorAndGrowsWithNoise) {
  const Matrix moved = motion({0, 1, 0}, 6, {4, 2, -3});
  double quiet = 0;
  for (const double noise : {10.0, 250.0}) {
    const auto found = register_rigid(scan(volume::kIdentity, kMr, noise), scan(moved, kMr, noise));
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_LT(furthest(volume::inverse_of_rigid(found->to_fixed), moved),
              4 * found->residual_mm + 0.5);
    if (noise > 100) EXPECT_GT(found->residual_mm, quiet);
    quiet = found->residual_mm;
  }
}

TEST(Registration, RefusesWhatCannotBeAligned) {
  const CoarseScan head = scan(volume::kIdentity, kCt, 10, {-90, -105, -95}, {90, 100, 95}, 5);
  CoarseScan flat = head, noise = head;
  std::fill(flat.values.begin(), flat.values.end(), 7.0F);
  std::mt19937 random(3);
  std::normal_distribution<float> grain(0, 100);
  for (float& value : noise.values) value = grain(random);
  EXPECT_EQ(register_rigid(head, flat).error().field, "no_structure");
  EXPECT_EQ(register_rigid(head, noise).error().field, "not_converged");
  EXPECT_EQ(register_rigid(noise, head).error().field, "not_converged");
}

TEST(Registration, ReducesAScanInItsPlace) {
  volume::Volume volume;
  volume.header.size = {200, 220, 240};
  volume.header.spacing = {1, 1, 1};
  volume.header.direction = {0, -1, 0, 1, 0, 0, 0, 0, 1};
  volume.header.origin = {10, 20, 30};
  for (std::uint32_t z = 0; z < 240; ++z) {
    for (std::uint32_t y = 0; y < 220; ++y) {
      for (std::uint32_t x = 0; x < 200; ++x) {
        volume.voxels.push_back(static_cast<std::int16_t>(x + 2 * y + 3 * z));
      }
    }
  }
  const CoarseScan coarse = reduced(volume);
  EXPECT_EQ(coarse.size, (std::array<std::uint32_t, 3>{100, 110, 120}));
  EXPECT_EQ(coarse.spacing, (std::array<double, 3>{2, 2, 2}));
  // The centre of the first eight voxels is at index 0.5 of each axis.
  EXPECT_NEAR(coarse.origin[0], 9.5, 1e-9);
  EXPECT_NEAR(coarse.origin[1], 20.5, 1e-9);
  EXPECT_NEAR(coarse.origin[2], 30.5, 1e-9);
  EXPECT_FLOAT_EQ(coarse.values[0], 3);
  EXPECT_FLOAT_EQ(coarse.values[1 + 100 * (2 + 110 * 3)], 2.5F + 2 * 4.5F + 3 * 6.5F);
}

}  // namespace
}  // namespace diaphane::ingest
