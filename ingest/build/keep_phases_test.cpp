#include "ingest/build/keep_phases.h"

#include <gtest/gtest.h>

namespace diaphane::ingest {
namespace {

using Numbers = std::vector<std::uint32_t>;

Numbers chosen(const std::string& phases, const std::string& every, std::uint32_t count) {
  return chosen_phases(*parse_phases(phases, every), count).value_or(Numbers());
}

TEST(KeepPhases, ChoosesListedOrEvenlySpacedPhases) {
  EXPECT_EQ(chosen("", "", 3), (Numbers{0, 1, 2}));
  EXPECT_EQ(chosen("", "4", 10), (Numbers{0, 4, 8}));
  EXPECT_EQ(chosen("", "4294967295", 10), (Numbers{0}));
  EXPECT_EQ(chosen("5,0,2,5", "", 6), (Numbers{0, 2, 5})) << "in order and once";
  EXPECT_TRUE(parse_phases("", "1")->is_all());
}

TEST(KeepPhases, RefusesOtherTextAndMissingPhases) {
  for (const char* phases : {",", "1,", "a", "-1", "1 2", "0,,1", "99999999999"})
    EXPECT_FALSE(parse_phases(phases, "")) << phases;
  for (const char* every : {"0", "-1", "two", "1.5"})
    EXPECT_FALSE(parse_phases("", every)) << every;
  EXPECT_FALSE(parse_phases("1", "2"));
  const auto beyond = chosen_phases(*parse_phases("0,6", ""), 6);
  ASSERT_FALSE(beyond);
  EXPECT_EQ(beyond.error().message, "there is no phase 6; the last one is 5");
}

TEST(KeepPhases, RemovesTheOtherPhasesOfAVolume) {
  volume::Volume volume;
  volume.header.size = {2, 2, 1};
  for (std::int16_t phase = 0; phase < 4; ++phase) {
    volume.header.phases.push_back({volume::PhaseKind::kTime, 10.0 * phase});
    volume.voxels.insert(volume.voxels.end(), 4, phase);
  }
  keep_phases(volume, Numbers{1, 3});
  EXPECT_EQ(volume.voxels, (std::vector<std::int16_t>{1, 1, 1, 1, 3, 3, 3, 3}));
  ASSERT_EQ(volume.header.phases.size(), 2U);
  EXPECT_EQ(volume.header.phases[1].value, 30);
  EXPECT_EQ(volume.header.minimum, 1);
  keep_phases(volume, Numbers{1});
  EXPECT_EQ(volume.voxels, (std::vector<std::int16_t>(4, 3)));
  EXPECT_TRUE(volume.header.phases.empty());
}

}  // namespace
}  // namespace diaphane::ingest
