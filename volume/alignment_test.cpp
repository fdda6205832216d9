#include "volume/alignment.h"

#include <gtest/gtest.h>

#include <cmath>

namespace diaphane::volume {
namespace {

/// A turn about z by `angle` and a shift.
Matrix turned(double angle, std::array<double, 3> shift) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c, -s, 0, shift[0], s, c, 0, shift[1], 0, 0, 1, shift[2], 0, 0, 0, 1};
}

Header header_of(std::array<std::uint32_t, 3> size, std::array<double, 3> spacing) {
  Header header;
  header.size = size;
  header.spacing = spacing;
  header.origin = {0, 0, 0};
  return header;
}

TEST(Alignment, ScansShareASpaceOnlyIfBothNameItAndHaveAPlace) {
  Header a = header_of({4, 4, 4}, {1, 1, 1}), b = a;
  EXPECT_FALSE(share_frame_of_reference(a, b));
  a.frame_of_reference = "x";
  EXPECT_FALSE(share_frame_of_reference(a, b));
  b.frame_of_reference = "x";
  EXPECT_TRUE(share_frame_of_reference(a, b));
  b.frame_of_reference = "y";
  EXPECT_FALSE(share_frame_of_reference(a, b));
  b.frame_of_reference = "x";
  b.origin.reset();
  EXPECT_FALSE(share_frame_of_reference(a, b));
}

TEST(Alignment, AcceptsRigidMotionsOnly) {
  EXPECT_EQ(rigid_motion({}).value(), kIdentity);
  Matrix m = turned(0.3, {10, -20, 30});
  EXPECT_EQ(rigid_motion(m).value(), m);
  for (const auto& [index, number] : std::vector<std::pair<std::size_t, double>>{
           {0, 2}, {3, 2e4}, {12, 0.1}, {15, 0.5}, {10, -1}, {7, std::nan("")}}) {
    Matrix bad = m;
    bad[index] = number;
    EXPECT_FALSE(rigid_motion(bad)) << index;
  }
  EXPECT_FALSE(rigid_motion(std::vector<double>(12)));
}

TEST(Alignment, InverseUndoesAMotion) {
  const Matrix m = turned(0.7, {5, 6, -7});
  const Matrix one = product(m, inverse_of_rigid(m));
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(one[i], kIdentity[i], 1e-12);
}

TEST(Alignment, IndicesOfBothScansNameTheSamePlace) {
  Header first = header_of({10, 20, 30}, {1, 2, 3});
  Header second = header_of({5, 5, 5}, {2, 2, 2});
  first.origin = {100, 50, 20};
  second.direction = {0, -1, 0, 1, 0, 0, 0, 0, 1};  // its x axis points along +y, y along -x
  second.origin = {7, 8, 9};
  const Matrix to_first = turned(0.4, {1, 2, 3});
  const Matrix map = between_indices(first, second, to_first);
  // The centre of voxel (1, 2, 3) of the second scan: 7 - 2*2, 8 + 2*1, 9 + 2*3.
  const auto place = moved(to_first, {3, 10, 15});
  const std::array<double, 3> in_first{(place[0] - 100) / 1 + 0.5, (place[1] - 50) / 2 + 0.5,
                                       (place[2] - 20) / 3 + 0.5};
  const auto there = moved(map, in_first);
  EXPECT_NEAR(there[0], 1.5, 1e-9);
  EXPECT_NEAR(there[1], 2.5, 1e-9);
  EXPECT_NEAR(there[2], 3.5, 1e-9);
}

TEST(Alignment, ScansWithoutAPlaceLieAboutTheOrigin) {
  Header header = header_of({4, 5, 6}, {1, 2, 3});
  header.origin.reset();
  const auto first = first_voxel(header);
  EXPECT_EQ(first, (std::array<double, 3>{-1.5, -4, -7.5}));
}

}  // namespace
}  // namespace diaphane::volume
