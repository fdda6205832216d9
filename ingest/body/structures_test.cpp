#include "ingest/body/structures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ingest/body/label_body.h"
#include "tests/support/ingest/part_phantoms.h"
#include "tests/support/ingest/phantoms.h"

namespace diaphane::ingest {
namespace {

using volume::Label;
using volume::Labels;
using volume::Volume;

constexpr double kLeastDice = 0.9;
constexpr Label kParts[] = {Label::kBone, Label::kLung, Label::kAirway, Label::kVessel};

Labels marked(const Volume& volume) {
  Labels labels = label_body(volume);
  mark_structures(volume, labels);
  return labels;
}

std::size_t voxels(const Labels& labels, Label label) {
  return static_cast<std::size_t>(
      std::count(labels.voxels.begin(), labels.voxels.end(), static_cast<std::uint8_t>(label)));
}

void expect_no_parts(const Volume& volume, const char* what) {
  const Labels labels = marked(volume);
  for (const Label part : kParts) {
    EXPECT_EQ(voxels(labels, part), 0U) << what << ", part " << static_cast<int>(part);
  }
}

TEST(Structures, OfAChestWithContrastMediumAreFound) {
  const PartPhantom phantom = chest({.blood = 320});
  const Labels labels = marked(phantom.volume);
  for (const Label part : kParts) {
    EXPECT_GE(dice(phantom, labels, part), kLeastDice) << static_cast<int>(part);
  }
}

TEST(Structures, OfAChestWithoutContrastMediumHaveNoVessels) {
  for (const int marrow : {170, 260}) {  // an adult's, and a child's, as dense as contrast medium
    const PartPhantom phantom = chest({.marrow = marrow});
    const Labels labels = marked(phantom.volume);
    for (const Label part : {Label::kBone, Label::kLung, Label::kAirway}) {
      EXPECT_GE(dice(phantom, labels, part), kLeastDice) << static_cast<int>(part) << " " << marrow;
    }
    EXPECT_EQ(voxels(labels, Label::kVessel), 0U) << marrow;
  }
}

TEST(Structures, AreFoundInNoiseInCoarseSlicesAndInAnyOrientation) {
  ChestOptions coronal{.blood = 300};
  coronal.direction = {-1, 0, 0, 0, 0, 1, 0, 1, 0};
  for (const ChestOptions& options :
       {ChestOptions{.blood = 350, .noise = 35},
        ChestOptions{.blood = 280, .spacing = {0.9, 0.9, 5}}, coronal}) {
    const PartPhantom phantom = chest(options);
    const Labels labels = marked(phantom.volume);
    // Bone that is thinner than a slice does not enclose its marrow.
    constexpr double kThick = 2.5, kLeastOfCoarseBone = 0.75;
    const double bone = options.spacing[2] > kThick ? kLeastOfCoarseBone : kLeastDice;
    for (const Label part : kParts) {
      EXPECT_GE(dice(phantom, labels, part), part == Label::kBone ? bone : kLeastDice)
          << static_cast<int>(part) << " at a blood of " << options.blood;
    }
  }
}

TEST(Structures, OfAnAbdomenIncludeNeitherLungsNorAirwaysNorVessels) {
  const PartPhantom phantom = abdomen();
  const Labels labels = marked(phantom.volume);
  EXPECT_GE(dice(phantom, labels, Label::kBone), kLeastDice);
  for (const Label part : {Label::kLung, Label::kAirway, Label::kVessel}) {
    EXPECT_EQ(voxels(labels, part), 0U) << static_cast<int>(part);
  }
}

TEST(Structures, IncludeNoGasBelowTheLungs) {
  PartPhantom phantom = chest();
  const auto& header = phantom.volume.header;
  std::vector<std::size_t> gas;
  std::size_t i = 0;
  for (std::uint32_t z = 0; z < header.size[2]; ++z) {
    for (std::uint32_t y = 0; y < header.size[1]; ++y) {
      for (std::uint32_t x = 0; x < header.size[0]; ++x, ++i) {
        if (phantom.truth[i] == Label::kAirway) phantom.volume.voxels[i] = 40;
        // A bubble and an upright tube in thin walls at the lower ends of the lungs.
        const auto mm = [&](std::uint32_t index, std::size_t axis) {
          return (index + 0.5 - header.size[axis] / 2.0) * header.spacing[axis];
        };
        const double bubble = std::hypot(mm(x, 0) - 72, mm(y, 1) + 5, mm(z, 2) + 105) - 22;
        const double tube =
            std::max(std::hypot(mm(x, 0) + 30, mm(y, 1) - 20) - 12, std::abs(mm(z, 2) + 100) - 25);
        if (std::min(bubble, tube) < 1.2) {
          const bool is_gas = std::min(bubble, tube) < 0;
          const int noise = static_cast<int>(i * 7919 % 101) - 50;
          phantom.volume.voxels[i] = static_cast<std::int16_t>(is_gas ? -1000 + noise : 40);
          phantom.truth[i] = Label::kBody;
          if (is_gas) gas.push_back(i);
        }
      }
    }
  }
  volume::measure(phantom.volume);
  const Labels labels = marked(phantom.volume);
  EXPECT_EQ(voxels(labels, Label::kAirway), 0U);
  EXPECT_GE(dice(phantom, labels, Label::kLung), kLeastDice);
  const auto lung = std::count_if(gas.begin(), gas.end(), [&](std::size_t voxel) {
    return labels.voxels[voxel] == static_cast<std::uint8_t>(Label::kLung);
  });
  // A tenth of the gas has values of lung tissue. Less than half of it is in the outermost cells.
  EXPECT_LE(static_cast<double>(lung), 0.05 * static_cast<double>(gas.size()));
}

TEST(Structures, IncludeNoContrastMediumInTheBowel) {
  for (const int value : {300, 440}) {  // the second is as dense as bone
    const PartPhantom phantom = abdomen(value);
    const Labels labels = marked(phantom.volume);
    EXPECT_EQ(voxels(labels, Label::kVessel), 0U) << value;
    EXPECT_GE(dice(phantom, labels, Label::kBone), kLeastDice) << value;
  }
}

TEST(Structures, AreSoughtInCtInHounsfieldUnitsOnly) {
  const PartPhantom phantom = chest({.blood = 320});
  for (const auto modality :
       {volume::Modality::kMr, volume::Modality::kPt, volume::Modality::kOther}) {
    Volume other = phantom.volume;
    other.header.modality = modality;
    expect_no_parts(other, "another modality");
  }
  Volume bytes = phantom.volume, stored = phantom.volume;
  for (std::size_t i = 0; i < bytes.voxels.size(); ++i) {
    bytes.voxels[i] = static_cast<std::int16_t>(std::clamp((bytes.voxels[i] + 1000) / 8, 0, 255));
    stored.voxels[i] = static_cast<std::int16_t>(stored.voxels[i] + 1024);
  }
  volume::measure(bytes);
  expect_no_parts(bytes, "8-bit values");
  volume::measure(stored);
  expect_no_parts(stored, "values that start at 0");
}

TEST(Structures, OfAScanThatShowsOnlyVesselsAreFound) {
  PartPhantom phantom = chest({.blood = 320});
  for (std::size_t i = 0; i < phantom.truth.size(); ++i) {
    auto& value = phantom.volume.voxels[i];
    if (phantom.truth[i] == Label::kVessel) continue;
    // What was cut out has 0, and some of the tissue beside the vessels is left.
    value = static_cast<std::int16_t>(i % 7 == 0 && phantom.truth[i] == Label::kBody ? 30 : 0);
    phantom.truth[i] = Label::kBody;
  }
  volume::measure(phantom.volume);
  const Labels labels = marked(phantom.volume);
  EXPECT_GE(dice(phantom, labels, Label::kVessel), kLeastDice);
  EXPECT_EQ(voxels(labels, Label::kBone), 0U);
}

/// A body of 70 x 70 x 60 voxels of 1.1 mm. `value` returns those of its voxels.
template <typename Value>
Volume block(Value value) {
  Volume volume;
  volume.header.size = {80, 80, 60};
  volume.header.spacing = {1.1, 1.1, 1.1};
  volume.header.modality = volume::Modality::kCt;
  for (int z = 0; z < 60; ++z) {
    for (int y = 0; y < 80; ++y) {
      for (int x = 0; x < 80; ++x) {
        const bool body = std::min({x, y, 79 - x, 79 - y}) >= 5;
        volume.voxels.push_back(static_cast<std::int16_t>(body ? value(x, y, z) : -1000));
      }
    }
  }
  volume::measure(volume);
  return volume;
}

TEST(Structures, IncludeThePartlyBonyVoxelsAroundDenseBone) {
  const auto layer_of = [](int x, int y, int z) {
    return std::max({std::abs(x - 40), std::abs(y - 40), std::abs(z - 30)}) - 10;
  };
  const Labels labels = marked(block([&](int x, int y, int z) {
    if (std::max({std::abs(x - 62), std::abs(y - 40), std::abs(z - 30)}) <= 2)
      return 700;  // 0.17 ml
    const int layer = layer_of(x, y, z);
    return layer <= 0 ? 700 : layer <= 2 || x < 12 ? 150 : 40;
  }));
  const auto label = [&](std::size_t x) {
    return static_cast<Label>(labels.voxels[x + 80 * (40 + 80 * std::size_t{30})]);
  };
  EXPECT_EQ(label(50), Label::kBone);
  EXPECT_EQ(label(51), Label::kBone) << "the first layer";
  EXPECT_EQ(label(52), Label::kBody) << "the second";
  EXPECT_EQ(label(10), Label::kBody) << "far away";
  EXPECT_EQ(label(62), Label::kBody) << "as small as a plaque";
}

TEST(Structures, IncludeNarrowVesselsOnlyWhereAWideOneShowsContrastMedium) {
  const auto vessels = [](bool wide) {
    const Labels labels = marked(block([=](int x, int y, int z) {
      const bool narrow = std::hypot(x - 20, y - 20) * 1.1 < 4 && z > 10 && z < 24;
      return narrow || (wide && std::hypot(x - 50, y - 50) * 1.1 < 12) ? 320 : 40;
    }));
    EXPECT_EQ(voxels(labels, Label::kBone), 0U);
    return voxels(labels, Label::kVessel);
  };
  // 14 mm of a radius of 4 mm, and 66 mm of 12 mm, in voxels of 1.33 mm3.
  EXPECT_EQ(vessels(false), 0U);
  const double expected = 3.14159 * (14.3 * 4 * 4 + 66 * 12 * 12) / 1.331;
  EXPECT_NEAR(static_cast<double>(vessels(true)), expected, 0.02 * expected);
}

TEST(Structures, LeaveMetalSupportAndSurroundingsAsTheyAre) {
  for (const char* name : {"head on a headrest", "trunk and arms on a table"}) {
    Phantom phantom = make_phantom(name);
    const auto& size = phantom.volume.header.size;
    const std::size_t middle =
        size[0] / 2 + std::size_t{size[0]} * (size[1] / 2 + size[1] * std::size_t{size[2] / 2});
    phantom.volume.voxels[middle] = 3071;  // a screw
    volume::measure(phantom.volume);
    const Labels before = label_body(phantom.volume);
    ASSERT_GT(voxels(before, Label::kMetal), 0U);
    Labels after = before;
    mark_structures(phantom.volume, after);
    constexpr auto kBody = static_cast<std::uint8_t>(Label::kBody);
    for (std::size_t i = 0; i < before.voxels.size(); ++i) {
      ASSERT_TRUE(before.voxels[i] == kBody ? volume::is_body(after.voxels[i])
                                            : before.voxels[i] == after.voxels[i])
          << name;
    }
    EXPECT_EQ(voxels(after, Label::kVessel), 0U) << "the even spine is too dense for blood";
  }
}

TEST(Structures, OfAScanWithPhasesAreThoseOfTheFirst) {
  Volume scan = chest({.blood = 320, .spacing = {2.2, 2.2, 3}}).volume;
  const Labels still = marked(scan);
  const std::size_t count = scan.voxels.size();
  scan.voxels.resize(2 * count, 40);
  scan.header.phases = {{volume::PhaseKind::kTime, 0}, {volume::PhaseKind::kTime, 40}};
  const auto found = volume::decode(found_labels(scan), scan.header.size);
  ASSERT_TRUE(found.has_value());
  for (const Label part : kParts) {
    EXPECT_GT(voxels(still, part), 0U) << static_cast<int>(part);
    EXPECT_EQ(voxels(*found, part), voxels(still, part)) << static_cast<int>(part);
  }
}

TEST(Structures, AreNotSoughtInTinyOrEmptyVolumes) {
  for (const std::array<std::uint32_t, 3> size :
       {std::array<std::uint32_t, 3>{0, 0, 0}, {1, 1, 1}, {2, 3, 1}, {40, 1, 30}}) {
    for (const int value : {-1000, 40, 300, 1200}) {
      Volume volume;
      volume.header.size = size;
      volume.header.modality = volume::Modality::kCt;
      volume.voxels.assign(volume.header.voxel_count(), static_cast<std::int16_t>(value));
      if (!volume.voxels.empty()) volume.voxels.front() = -1000;
      volume::measure(volume);
      const Labels labels = marked(volume);
      EXPECT_EQ(voxels(labels, Label::kLung) + voxels(labels, Label::kVessel), 0U);
    }
  }
}

}  // namespace
}  // namespace diaphane::ingest
