#include "ingest/body/label_body.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "tests/support/ingest/phantoms.h"

namespace diaphane::ingest {
namespace {

using volume::Label;
using volume::Labels;
using volume::Volume;

constexpr double kLeastKept = 0.99, kLeastHidden = 0.95;

class LabelBody : public testing::TestWithParam<std::string> {};

TEST_P(LabelBody, KeepsTheBodyAndHidesItsSupport) {
  const Phantom phantom = make_phantom(GetParam());
  const Labels labels = label_body(phantom.volume);
  ASSERT_EQ(labels.size, phantom.volume.header.size);
  ASSERT_EQ(labels.voxels.size(), phantom.volume.voxels.size());
  const Agreement found = agreement(phantom, labels.voxels);
  EXPECT_GE(found.kept, kLeastKept);
  EXPECT_GE(found.hidden, kLeastHidden);
}

INSTANTIATE_TEST_SUITE_P(Phantoms, LabelBody, testing::ValuesIn(phantom_names()),
                         [](const testing::TestParamInfo<std::string>& info) {
                           std::string name = info.param;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return !std::isalnum(c); },
                               '_');
                           return name;
                         });

Volume constant(std::array<std::uint32_t, 3> size, std::int16_t value, volume::Modality modality) {
  Volume volume;
  volume.header.size = size;
  volume.header.modality = modality;
  volume.voxels.assign(volume.header.voxel_count(), value);
  volume::measure(volume);
  return volume;
}

std::array<std::size_t, 4> counts(const Labels& labels) {
  std::array<std::size_t, 4> n{};
  for (const std::uint8_t label : labels.voxels) ++n[label];
  return n;
}

std::size_t voxels(const Labels& labels, Label label) {
  return counts(labels)[static_cast<std::size_t>(label)];
}

TEST(LabelBodyOfOddVolumes, LabelsEveryVoxelOfTinyAndConstantVolumes) {
  for (const auto modality : {volume::Modality::kCt, volume::Modality::kMr}) {
    for (const int value : {-1000, 0, 40, 3000}) {
      for (const auto& size : std::vector<std::array<std::uint32_t, 3>>{
               {1, 1, 1}, {2, 3, 1}, {1, 40, 1}, {40, 30, 20}}) {
        const Labels labels =
            label_body(constant(size, static_cast<std::int16_t>(value), modality));
        EXPECT_EQ(labels.voxels.size(), std::size_t{size[0]} * size[1] * size[2]);
        EXPECT_EQ(voxels(labels, Label::kSupport), 0U);
      }
    }
  }
  EXPECT_TRUE(label_body(constant({0, 0, 0}, 0, volume::Modality::kCt)).voxels.empty());
}

TEST(LabelBodyOfOddVolumes, KeepsScatteredVesselsWithoutSkinOrSkull) {
  Volume volume = constant({120, 120, 100}, 0, volume::Modality::kOther);
  for (int x = 10; x < 110; x += 12) {
    for (int y = 10; y < 110; y += 12) {
      for (int z = 5; z < 95; ++z) {
        const int a = x + (z * (x % 5)) / 30, b = y + (z * (y % 7)) / 40;
        for (int i = 0; i < 9; ++i) {
          volume.voxels[static_cast<std::size_t>(a + i % 3 + 120 * (b + i / 3 + 120 * z))] = 400;
        }
      }
    }
  }
  volume::measure(volume);
  const Labels labels = label_body(volume);
  for (std::size_t i = 0; i < labels.voxels.size(); ++i) {
    if (volume.voxels[i] == 400) {
      ASSERT_EQ(static_cast<Label>(labels.voxels[i]), Label::kBody) << i;
    }
  }
}

TEST(LabelBodyOfAHead, IncludesAirwaysAndAMarginOfAir) {
  const Phantom phantom = make_phantom("head without a headrest");
  const Labels labels = label_body(phantom.volume);
  const auto& size = labels.size;
  const auto label = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return static_cast<Label>(labels.voxels[x + std::size_t{size[0]} * (y + size[1] * z)]);
  };
  // The airway at (0, -50, -40) mm, and the first voxel of air beyond the vertex.
  EXPECT_EQ(label(60, 45, 35), Label::kBody);
  const std::uint32_t above = 102;
  ASSERT_LT(phantom.volume.voxels[60 + 120 * (70 + 140 * std::size_t{above})], -900);
  EXPECT_EQ(label(60, 70, above), Label::kBody);
  EXPECT_EQ(label(60, 70, above + 2), Label::kOutside);
  EXPECT_EQ(voxels(labels, Label::kSupport), 0U);
}

/// Counts the voxels of the body in a part of a head phantom that are not labelled as body. The
/// place is in voxels of 2 mm from the middle.
std::size_t lost(const std::string& name, bool (*part)(double x, double y)) {
  const Phantom phantom = make_phantom(name);
  const Labels labels = label_body(phantom.volume);
  const auto& size = labels.size;
  std::size_t lost = 0, all = 0;
  for (std::size_t i = 0; i < labels.voxels.size(); ++i) {
    const double x = static_cast<double>(i % size[0]) - size[0] / 2.0;
    const double y = static_cast<double>(i / size[0] % size[1]) - size[1] / 2.0;
    if (phantom.truth[i] != 1 || !part(x, y)) continue;
    ++all;
    lost += static_cast<Label>(labels.voxels[i]) != Label::kBody ? 1 : 0;
  }
  EXPECT_GT(all, 100U);
  return lost;
}

TEST(LabelBodyOfAHead, KeepsEarsAndNose) {
  const auto ears = [](double x, double) { return std::abs(x) > 40; };
  const auto nose = [](double, double y) { return y < -47; };
  for (const char* name : {"head on a headrest", "head without a headrest", "MR head in a frame"}) {
    EXPECT_EQ(lost(name, ears), 0U) << name;
    EXPECT_EQ(lost(name, nose), 0U) << name;
  }
}

TEST(LabelBodyOfOddVolumes, LeavesAMillimetreOfAirAtSmallVoxels) {
  Volume volume = constant({100, 100, 60}, -1000, volume::Modality::kCt);
  volume.header.spacing = {0.5, 0.5, 1};
  for (std::size_t z = 15; z < 45; ++z) {
    for (std::size_t y = 20; y < 80; ++y) {
      for (std::size_t x = 20; x < 80; ++x) volume.voxels[x + 100 * (y + 100 * z)] = 40;
    }
  }
  volume::measure(volume);
  const Labels labels = label_body(volume);
  const auto body = [&](std::size_t x, std::size_t z) {
    return static_cast<Label>(labels.voxels[x + 100 * (50 + 100 * z)]) == Label::kBody;
  };
  EXPECT_TRUE(body(18, 30) && body(81, 30) && body(50, 14) && body(50, 45));
  EXPECT_FALSE(body(17, 30) || body(82, 30) || body(50, 13) || body(50, 46));
}

TEST(LabelBodyOfAHead, MarksMetalInTheBodyOnly) {
  Phantom phantom = make_phantom("head on a headrest");
  const auto& size = phantom.volume.header.size;
  const auto at = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) -> std::size_t {
    return x + std::size_t{size[0]} * (y + size[1] * z);
  };
  phantom.volume.voxels[at(60, 40, 60)] = 3071;   // a screw in the skull
  phantom.volume.voxels[at(60, 128, 60)] = 3071;  // a screw in the shell
  volume::measure(phantom.volume);
  const Labels labels = label_body(phantom.volume);
  EXPECT_EQ(static_cast<Label>(labels.voxels[at(60, 40, 60)]), Label::kMetal);
  EXPECT_EQ(static_cast<Label>(labels.voxels[at(60, 128, 60)]), Label::kSupport);
  EXPECT_EQ(voxels(labels, Label::kMetal), 1U);
}

TEST(LabelBodyOfAHead, IsDeterministic) {
  const Phantom phantom = make_phantom("head on a headrest");
  EXPECT_EQ(label_body(phantom.volume).voxels, label_body(phantom.volume).voxels);
}

TEST(FoundLabels, KeepWhatMovesInAnyPhase) {
  // The second phase is the first one, turned upside down, so that the body is somewhere else.
  Volume scan = make_phantom("head without a headrest").volume;
  const Labels still = label_body(scan);
  Volume turned = scan;
  std::reverse(turned.voxels.begin(), turned.voxels.end());
  const Labels moved = label_body(turned);
  scan.header.phases = {{volume::PhaseKind::kTime, 0}, {volume::PhaseKind::kTime, 40}};
  scan.voxels.insert(scan.voxels.end(), turned.voxels.begin(), turned.voxels.end());
  const auto found = volume::decode(found_labels(scan), scan.header.size);
  ASSERT_TRUE(found.has_value());
  std::size_t only_later = 0;
  for (std::size_t i = 0; i < still.voxels.size(); ++i) {
    const auto body = [&](const Labels& labels) {
      return labels.voxels[i] != static_cast<std::uint8_t>(Label::kOutside) &&
             labels.voxels[i] != static_cast<std::uint8_t>(Label::kSupport);
    };
    ASSERT_EQ(body(*found), body(still) || body(moved)) << i;
    if (body(moved) && !body(still)) ++only_later;
  }
  EXPECT_GT(only_later, 1000U);
}

}  // namespace
}  // namespace diaphane::ingest
