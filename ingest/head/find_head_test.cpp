#include "ingest/head/find_head.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/support/volume/test_shapes.h"

namespace diaphane::ingest {
namespace {

using volume::ellipse;
using volume::ellipsoid;
using volume::Modality;
using volume::Vector;
using volume::Volume;

/// Returns a volume of 2.5 mm voxels along the patient's axes, with a value per place (mm, origin
/// at its centre).
Volume made(Modality modality, const Vector& size_mm,
            const std::function<int(const Vector&)>& value, double turn = 0) {
  constexpr double kSpacing = 2.5;
  Volume volume;
  volume.header.modality = modality;
  volume.header.spacing = {kSpacing, kSpacing, kSpacing};
  const double c = std::cos(turn), s = std::sin(turn);
  volume.header.direction = {c, 0, s, 0, 1, 0, -s, 0, c};
  for (std::size_t i = 0; i < 3; ++i) {
    volume.header.size[i] = static_cast<std::uint32_t>(size_mm[i] / kSpacing);
  }
  volume.voxels.reserve(volume.header.voxel_count());
  for (std::uint32_t z = 0; z < volume.header.size[2]; ++z) {
    for (std::uint32_t y = 0; y < volume.header.size[1]; ++y) {
      for (std::uint32_t x = 0; x < volume.header.size[0]; ++x) {
        const Vector index{x + 0.5 - volume.header.size[0] / 2.0,
                           y + 0.5 - volume.header.size[1] / 2.0,
                           z + 0.5 - volume.header.size[2] / 2.0};
        Vector place{};
        for (std::size_t p = 0; p < 3; ++p) {
          for (std::size_t v = 0; v < 3; ++v) {
            place[p] += volume.header.direction[3 * p + v] * index[v] * kSpacing;
          }
        }
        volume.voxels.push_back(static_cast<std::int16_t>(value(place)));
      }
    }
  }
  volume::measure(volume);
  return volume;
}

constexpr Vector kBrainMiddle{0, 10, 30};

/// An ellipsoidal brain case, with a face and neck below and in front of it, in HU.
int head_ct(const Vector& p) {
  const double brain = ellipsoid(p, kBrainMiddle, {66, 82, 62});
  if (brain < 1) return 35;
  if (ellipsoid(p, kBrainMiddle, {73, 89, 69}) < 1) return 900;
  if (ellipsoid(p, kBrainMiddle, {79, 95, 75}) < 1) return 40;
  const bool face = ellipsoid(p, {0, -55, -45}, {55, 45, 60}) < 1;
  const bool sinus = ellipsoid(p, {0, -60, -30}, {15, 15, 15}) < 1;
  const bool neck = p[2] < -20 && ellipse(p[0], p[1] - 20, 58, 60) < 1;
  if (sinus) return -1000;
  return face || neck ? 40 : -1000;
}

int abdomen_ct(const Vector& p) {
  if (ellipse(p[0], p[1], 165, 115) > 1) return -1000;
  if (std::hypot(p[0], p[1] - 70) < 22) return std::hypot(p[0], p[1] - 70) < 9 ? 30 : 500;
  // Ribs: pieces of a ring that slope down to the front.
  const double ring = ellipse(p[0], p[1], 150, 100);
  const double along = std::fmod(std::abs(p[2] + 0.5 * p[1]), 26);
  if (ring > 0.93 && ring < 1.0 && along < 9 && p[1] > -80) return 700;
  return ellipse(p[0], p[1], 140, 92) < 1 ? 55 : -90;
}

int limb_ct(const Vector& p) {
  const double bone = std::hypot(p[0], p[1]);
  if (bone < 9) return -60;
  if (bone < 16) return 1200;
  return bone < 75 ? 50 : -1000;
}

/// The ring of the pelvis, open in front except for a few levels.
int pelvis_ct(const Vector& p) {
  if (ellipse(p[0], p[1], 180, 120) > 1) return -1000;
  const double ring = ellipse(p[0], p[1], 110, 80);
  if (ring > 0.85 && ring < 1.05 && (p[1] > -35 || std::abs(p[2]) < 8)) return 600;
  return 40;
}

int head_mr(const Vector& p) {
  const int hu = head_ct(p);
  return hu == 900 ? 30 : hu == -1000 ? 5 : hu == 35 ? 400 : 300;
}

const Vector kHeadSize{220, 260, 230};

TEST(FindHead, RecognizesHeadInCtByItsBrainCase) {
  for (const double turn : {0.0, 0.2}) {
    const auto found = find_head(made(Modality::kCt, kHeadSize, head_ct, turn));
    EXPECT_TRUE(found.found);
    EXPECT_EQ(found.sign, "brain_case");
    EXPECT_TRUE(found.proposal.has_value());
  }
}

TEST(FindHead, ToleratesHoleInTheSkull) {
  const auto found = find_head(made(Modality::kCt, kHeadSize, [](const Vector& p) {
    const bool hole = p[0] > 40 && std::abs(p[1]) < 25 && std::abs(p[2] - 40) < 25;
    return hole && head_ct(p) > 500 ? 30 : head_ct(p);
  }));
  EXPECT_TRUE(found.found);
}

TEST(FindHead, RecognizesHeadInMrByItsShape) {
  const auto found = find_head(made(Modality::kMr, kHeadSize, head_mr));
  EXPECT_TRUE(found.found);
  EXPECT_EQ(found.sign, "head_shape");
  EXPECT_TRUE(found.proposal.has_value());
}

TEST(FindHead, ProposedCutRemovesTheFaceAndKeepsTheBrain) {
  for (const auto modality : {Modality::kCt, Modality::kMr}) {
    const Volume volume = made(modality, kHeadSize, modality == Modality::kCt ? head_ct : head_mr);
    const auto found = find_head(volume);
    ASSERT_TRUE(found.proposal.has_value());
    const volume::Region::Plane plane = found.proposal->planes.at(0);
    const auto goes = [&](const Vector& p) {
      double side = 0;
      for (std::size_t i = 0; i < 3; ++i) side += (p[i] - plane.point[i]) * plane.normal[i];
      return side > 0;
    };
    EXPECT_TRUE(goes({0, -98, -40})) << "the tip of the nose";
    EXPECT_TRUE(goes({0, -85, -80})) << "the chin";
    EXPECT_TRUE(goes({30, -80, -25})) << "an eye";
    int brain = 0, lost = 0;
    for (double z = -60; z < 100; z += 4) {
      for (double y = -100; y < 110; y += 4) {
        for (double x = -80; x < 80; x += 4) {
          if (ellipsoid({x, y, z}, kBrainMiddle, {66, 82, 62}) >= 1) continue;
          ++brain;
          lost += goes({x, y, z});
        }
      }
    }
    // In MR, the brain is only an estimate, so a fiftieth of it may be lost.
    EXPECT_LE(lost, modality == Modality::kCt ? 0 : brain / 50) << brain;
  }
}

TEST(FindHead, CutFollowsTiltedAndTurnedHeadsInCt) {
  for (const bool nods : {true, false}) {
    for (const double degrees : {-35.0, -20.0, 20.0, 35.0}) {
      const double c = std::cos(degrees * 0.0174533), s = std::sin(degrees * 0.0174533);
      const auto turned = [&](const Vector& p, double by) {
        return nods ? Vector{p[0], c * p[1] - by * s * p[2], by * s * p[1] + c * p[2]}
                    : Vector{c * p[0] - by * s * p[1], by * s * p[0] + c * p[1], p[2]};
      };
      const auto found = find_head(made(Modality::kCt, {260, 280, 260},
                                        [&](const Vector& p) { return head_ct(turned(p, -1)); }));
      ASSERT_TRUE(found.proposal.has_value()) << degrees;
      const volume::Region::Plane plane = found.proposal->planes.at(0);
      const auto before = [&](const Vector& own) {  // mm in front of the plane
        const Vector p = turned(own, 1);
        double side = 0;
        for (std::size_t i = 0; i < 3; ++i) side += (p[i] - plane.point[i]) * plane.normal[i];
        return side;
      };
      EXPECT_GT(before({0, -98, -40}), 0) << "the tip of the nose, " << degrees;
      EXPECT_GT(before({0, -85, -80}), 0) << "the chin, " << degrees;
      EXPECT_GT(before({30, -80, -25}), 0) << "an eye, " << degrees;
      double nearest = -1e9;
      for (double polar = 0; polar < 3.2; polar += 0.1) {
        for (double around = 0; around < 6.3; around += 0.1) {
          nearest = std::max(nearest, before({66 * std::sin(polar) * std::cos(around),
                                              10 + 82 * std::sin(polar) * std::sin(around),
                                              30 + 62 * std::cos(polar)}));
        }
      }
      EXPECT_LT(nearest, 0) << "the brain, " << degrees;
    }
  }
}

TEST(FindHead, FindsNoHeadInOtherBodyParts) {
  const Vector trunk{400, 300, 200};
  EXPECT_FALSE(find_head(made(Modality::kCt, trunk, abdomen_ct)).found);
  EXPECT_FALSE(find_head(made(Modality::kCt, trunk, pelvis_ct)).found);
  EXPECT_FALSE(find_head(made(Modality::kCt, {200, 200, 300}, limb_ct)).found);
  const auto as_mr = [](int (*ct)(const Vector&)) {
    return [ct](const Vector& p) {
      const int hu = ct(p);
      return hu < -500 ? 5 : hu > 200 ? 40 : hu < 0 ? 600 : 300;
    };
  };
  EXPECT_FALSE(find_head(made(Modality::kMr, trunk, as_mr(abdomen_ct))).found);
  EXPECT_FALSE(find_head(made(Modality::kMr, {200, 200, 300}, as_mr(limb_ct))).found);
}

TEST(FindHead, FindsNoHeadInEmptyVolume) {
  const auto empty =
      find_head(made(Modality::kCt, {100, 100, 100}, [](const Vector&) { return -1000; }));
  EXPECT_FALSE(empty.found);
  EXPECT_EQ(empty.sign, "none");
  EXPECT_FALSE(empty.proposal.has_value());
  EXPECT_FALSE(
      find_head(made(Modality::kMr, {100, 100, 100}, [](const Vector&) { return 0; })).found);
  EXPECT_FALSE(
      find_head(made(Modality::kCt, {20, 20, 20}, [](const Vector&) { return 300; })).found);
  EXPECT_EQ(to_json(empty), R"({"found":false,"proposal":null,"sign":"none"})");
}

}  // namespace
}  // namespace diaphane::ingest
