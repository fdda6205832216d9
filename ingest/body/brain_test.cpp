#include "ingest/body/brain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ingest/body/label_body.h"
#include "tests/support/ingest/phantoms.h"

namespace diaphane::ingest {
namespace {

using volume::Label;
using volume::Labels;
using volume::Volume;

constexpr std::uint32_t kSide = 84;
constexpr double kVoxel = 2.5;  // mm

double ellipsoid(double x, double y, double z, double a, double b, double c) {
  return std::sqrt(x * x / (a * a) + y * y / (b * b) + z * z / (c * c));
}

/// Values of a T1 scan of a head, by mm from its middle: brain with folds, dark fluid and bone, and
/// bright fat, above a neck.
int head(double x, double y, double z) {
  const double folds = 1 + 0.02 * std::sin(0.5 * x) * std::sin(0.4 * y + 1) * std::sin(0.45 * z);
  if (ellipsoid(x, y, z, 64, 80, 66) * folds < 1) return std::hypot(x, y, z) < 45 ? 640 : 500;
  if (ellipsoid(x, y, z, 75, 91, 77) < 1) return 60;
  if (ellipsoid(x, y, z, 82, 98, 84) < 1) return 800;
  return z < -50 && std::hypot(x, y - 10) < 55 ? 380 : 5;
}

template <typename Value>
Volume scan(Value value, volume::Modality modality = volume::Modality::kMr) {
  Volume volume;
  volume.header.size = {kSide, kSide, kSide};
  volume.header.spacing = {kVoxel, kVoxel, kVoxel};
  volume.header.modality = modality;
  std::mt19937 random(1);
  std::uniform_int_distribution<int> noise(0, 30);
  for (std::uint32_t k = 0; k < kSide; ++k) {
    for (std::uint32_t j = 0; j < kSide; ++j) {
      for (std::uint32_t i = 0; i < kSide; ++i) {
        const auto mm = [](std::uint32_t index) { return (index - 0.5 * kSide) * kVoxel; };
        volume.voxels.push_back(
            static_cast<std::int16_t>(value(mm(i), mm(j), mm(k)) + noise(random)));
      }
    }
  }
  volume::measure(volume);
  return volume;
}

struct Found {
  bool found = false;
  Labels labels;
};
Found find(const Volume& volume) {
  Found result{false, label_body(volume)};
  result.found = mark_brain(volume, result.labels);
  return result;
}

TEST(Brain, IsFoundInAHead) {
  const Volume volume = scan(head);
  const Found result = find(volume);
  ASSERT_TRUE(result.found);
  std::size_t brain = 0, kept = 0, fat = 0;
  std::size_t voxel = 0;
  for (std::uint32_t k = 0; k < kSide; ++k) {
    for (std::uint32_t j = 0; j < kSide; ++j) {
      for (std::uint32_t i = 0; i < kSide; ++i, ++voxel) {
        const bool marked = result.labels.voxels[voxel] == static_cast<std::uint8_t>(Label::kBrain);
        const auto mm = [](std::uint32_t index) { return (index - 0.5 * kSide) * kVoxel; };
        const double x = mm(i), y = mm(j), z = mm(k);
        if (ellipsoid(x, y, z, 64, 80, 66) < 0.98) {
          ++brain;
          kept += marked ? 1 : 0;
        } else if (ellipsoid(x, y, z, 75, 91, 77) > 1.02) {
          fat += marked ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GE(static_cast<double>(kept), 0.99 * static_cast<double>(brain));
  EXPECT_LE(static_cast<double>(fat), 0.01 * static_cast<double>(brain)) << "beyond the dark bone";
}

TEST(Brain, IsFoundInAnyOrientation) {
  Volume volume = scan([](double i, double j, double k) { return head(-j, -k, i); });
  volume.header.direction = {0, -1, 0, 0, 0, -1, 1, 0, 0};  // i to the head, j right, k forward
  EXPECT_TRUE(find(volume).found);
}

TEST(Brain, OfAScanWithoutTheRestOfTheHeadIsAllOfIt) {
  const Found result = find(scan([](double x, double y, double z) {
    return ellipsoid(x, y, z, 64, 80, 66) < 1 ? head(x, y, z) : 0;
  }));
  EXPECT_TRUE(result.found);
}

TEST(Brain, IsNotFoundWhereThereIsNone) {
  EXPECT_FALSE(find(scan([](double, double, double) { return 300; })).found) << "nothing but noise";
  EXPECT_FALSE(find(scan([](double x, double y, double z) {
                 return ellipsoid(x, y, z, 20, 20, 100) < 1 ? 500 : 5;
               })).found)
      << "a limb";
  EXPECT_FALSE(find(scan([](double x, double y, double) {
                 return std::hypot(x, y) < 95 ? 400 + static_cast<int>(2 * x) : 5;
               })).found)
      << "a trunk that leaves the scan above and below";
  for (const char* name : {"trunk and arms on a table", "head on a headrest"}) {
    EXPECT_FALSE(find(make_phantom(name).volume).found) << name << " in a CT";
  }
  EXPECT_FALSE(find(scan(head, volume::Modality::kPt)).found);
}

TEST(Brain, IsNotSoughtInTinyOrEmptyVolumes) {
  for (const std::array<std::uint32_t, 3> size :
       {std::array<std::uint32_t, 3>{0, 0, 0}, {1, 1, 1}, {2, 3, 1}}) {
    Volume volume;
    volume.header.size = size;
    volume.header.modality = volume::Modality::kMr;
    volume.voxels.assign(volume.header.voxel_count(), 7);
    volume::measure(volume);
    EXPECT_FALSE(find(volume).found);
  }
}

}  // namespace
}  // namespace diaphane::ingest
