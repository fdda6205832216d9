// Series that repeat their positions (case 8 of the ingest design), from generated files.
#include "ingest/dicom/phases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include "tests/support/ingest/test_series.h"

namespace diaphane::dicom {
namespace {

using namespace testing;
using volume::PhaseKind;

std::string bytes_of_double(double value) {
  const auto bytes = std::bit_cast<std::array<char, sizeof value>>(value);
  return {bytes.begin(), bytes.end()};
}

std::string bytes_of_float(float value) {
  const auto bytes = std::bit_cast<std::array<char, sizeof value>>(value);
  return {bytes.begin(), bytes.end()};
}

/// The identifier of slices that are left out.
constexpr const char* kMissing = "2.25.404404404";

/// Changes slice z of a phase. Returns false to leave it out.
using ChangeSlice = std::function<bool(int phase, int z, SeriesSpec&, SliceSpec&)>;

/// Returns the files of `phases` phases in no order, with instance numbers that say nothing. The
/// values of phase p are shifted up by p.
std::vector<std::string> files_of_phases(int phases, const ChangeSlice& change,
                                         Options options = plain_ct()) {
  std::mt19937 random(7);
  std::vector<std::string> files;
  for (int p = 0; p < phases; ++p) {
    options.change = [&](int z, SeriesSpec& series, SliceSpec& slice) {
      slice.instance_number = static_cast<int>(random() % 10000);
      series.intercept += p;
      if (!change(p, z, series, slice)) slice.sop_uid = kMissing;
    };
    for (std::string& file : files_of(options)) {
      if (file.find(kMissing) == std::string::npos) files.push_back(std::move(file));
    }
  }
  std::shuffle(files.begin(), files.end(), random);
  return files;
}

Series series_of(const std::vector<std::string>& files) {
  Scan scan = scan_of(files);
  EXPECT_EQ(scan.series.size(), 1U);
  return std::move(scan.series.front());
}

/// Checks that the slices of each phase are in their order, by the intercept that numbers phases.
void expect_phases(const Series& series, const std::vector<int>& phases, int slices = 20,
                   int first = 0) {
  const Assessment& a = series.assessment;
  ASSERT_TRUE(a.suitable) << a.text;
  ASSERT_EQ(a.size[2], static_cast<std::uint32_t>(slices));
  ASSERT_EQ(a.order.size(), phases.size() * static_cast<std::size_t>(slices));
  for (std::size_t i = 0; i < a.order.size(); ++i) {
    const Slice& slice = series.slices[a.order[i]];
    const auto z = static_cast<int>(i) % slices + first;
    EXPECT_EQ(slice.rescale.intercept, -1024 + phases[i / static_cast<std::size_t>(slices)]);
    EXPECT_NEAR((*slice.position)[2], -300 + 2 * z, 1e-6);
  }
}

std::vector<int> up_to(int n) {
  std::vector<int> all;
  for (int i = 0; i < n; ++i) all.push_back(i);
  return all;
}

TEST(Case8, OrdersACardiacSeriesByTriggerTimesThatVaryFromSliceToSlice) {
  const Series series = series_of(files_of_phases(10, [](int p, int z, SeriesSpec&, SliceSpec& s) {
    s.extra.push_back({0x0018, 0x1060, "DS", std::to_string(80 * p + z % 5), {}});
    return true;
  }));
  expect_phases(series, up_to(10));
  const auto& phases = series.assessment.phases;
  ASSERT_EQ(phases.size(), 10U);
  EXPECT_EQ(phases[0], (volume::Phase{PhaseKind::kTime, 0}));
  EXPECT_EQ(phases[9], (volume::Phase{PhaseKind::kTime, 720}));
  EXPECT_TRUE(series.assessment.repairs.empty());
}

TEST(Case8, PrefersThePercentageOfAHeartbeatToItsTime) {
  const Series series = series_of(files_of_phases(4, [](int p, int, SeriesSpec&, SliceSpec& s) {
    s.extra.push_back({0x0018, 0x1060, "DS", std::to_string(80 * p), {}});
    s.extra.push_back({0x0020, 0x9241, "FL", bytes_of_float(25.0F * static_cast<float>(p)), {}});
    return true;
  }));
  expect_phases(series, up_to(4));
  EXPECT_EQ(series.assessment.phases.at(3), (volume::Phase{PhaseKind::kCycle, 75}));
}

TEST(Case8, OrdersEchoesAndBValues) {
  const auto echoes = [](int p, int, SeriesSpec&, SliceSpec& s) {
    s.extra.push_back({0x0018, 0x0081, "DS", std::to_string(30 - 10 * p), {}});
    return true;
  };
  const Series multi_echo = series_of(files_of_phases(3, echoes));
  expect_phases(multi_echo, {2, 1, 0});
  EXPECT_EQ(multi_echo.assessment.phases.at(0), (volume::Phase{PhaseKind::kEcho, 10}));
  const Series diffusion = series_of(files_of_phases(3, [](int p, int, SeriesSpec&, SliceSpec& s) {
    // The acquisition time differs too, but the b-value means more.
    s.extra.push_back({0x0008, 0x0032, "TM", "10000" + std::to_string(9 - p), {}});
    s.extra.push_back({0x0018, 0x9087, "FD", bytes_of_double(500.0 * p), {}});
    return true;
  }));
  expect_phases(diffusion, {0, 1, 2});
  EXPECT_EQ(diffusion.assessment.phases.at(2), (volume::Phase{PhaseKind::kBValue, 1000}));
}

TEST(Case8, KeepsDirectionsOfTheSameBValueApart) {
  const Series series = series_of(files_of_phases(4, [](int p, int z, SeriesSpec&, SliceSpec& s) {
    s.extra.push_back({0x0018, 0x9087, "FD", bytes_of_double(p == 0 ? 0 : 1000), {}});
    s.instance_number = 100 * p + z;
    return true;
  }));
  expect_phases(series, up_to(4));
  EXPECT_EQ(series.assessment.phases.at(3), (volume::Phase{PhaseKind::kBValue, 1000}));
}

TEST(Case8, FallsBackToTheOrderOfInstances) {
  const Series series = series_of(files_of_phases(3, [](int p, int z, SeriesSpec&, SliceSpec& s) {
    s.instance_number = 100 * p + z;
    return true;
  }));
  expect_phases(series, up_to(3));
  EXPECT_EQ(series.assessment.phases.at(2), (volume::Phase{PhaseKind::kIndex, 2}));
}

bool with_time(int p, SliceSpec& slice) {
  slice.extra.push_back({0x0008, 0x0032, "TM", "1000" + std::to_string(10 + p), {}});
  return true;
}

TEST(Case8, LeavesOutAnIncompletePhase) {
  const Series cut_off = series_of(files_of_phases(6, [](int p, int z, SeriesSpec&, SliceSpec& s) {
    return with_time(p, s) && (p < 5 || z < 9);
  }));
  expect_phases(cut_off, up_to(5));
  ASSERT_EQ(cut_off.assessment.repairs.size(), 1U);
  EXPECT_EQ(cut_off.assessment.repairs[0], "1 phase was incomplete and left out");
  const Series with_a_hole =
      series_of(files_of_phases(6, [](int p, int z, SeriesSpec&, SliceSpec& s) {
        return with_time(p, s) && (p != 2 || z != 9);
      }));
  expect_phases(with_a_hole, {0, 1, 3, 4, 5});
}

TEST(Case8, KeepsThePositionsThatAllPhasesHave) {
  const Series series = series_of(files_of_phases(6, [](int p, int z, SeriesSpec&, SliceSpec& s) {
    return with_time(p, s) && (p != 1 || z > 0) && (p != 4 || z < 19);
  }));
  expect_phases(series, up_to(6), 18, 1);
  ASSERT_EQ(series.assessment.repairs.size(), 1U);
  EXPECT_EQ(series.assessment.repairs[0],
            "10 slices at the ends of some phases were left out, because other phases do not have "
            "them");
}

TEST(Case8, RefusesIfMostPhasesAreIncomplete) {
  const std::vector<std::string> files =
      files_of_phases(6, [](int p, int z, SeriesSpec&, SliceSpec& s) {
        return with_time(p, s) && (p < 2 || z != 3 + p);
      });
  EXPECT_EQ(choose(scan_of(files)).code, "incomplete_phases");
}

TEST(Case8, RefusesFewSlicesHoweverManyPhasesThereAre) {
  Options options = plain_ct();
  options.slices = 12;
  const std::vector<std::string> files = files_of_phases(
      10, [](int p, int, SeriesSpec&, SliceSpec& s) { return with_time(p, s); }, options);
  const Choice choice = choose(scan_of(files));
  EXPECT_EQ(choice.code, "too_few_slices");
  EXPECT_NE(choice.text.find("has 12,"), std::string::npos) << choice.text;
}

TEST(Case8, KeepsAsManyPhasesAsFit) {
  const std::vector<std::string> files =
      files_of_phases(7, [](int p, int, SeriesSpec&, SliceSpec& s) { return with_time(p, s); });
  MemorySource source(files);
  ScanLimits limits;
  limits.most_voxels = std::uint64_t{12} * 10 * 20 * 4;
  auto scan = dicom::scan(source, limits);
  ASSERT_TRUE(scan.has_value());
  expect_phases(scan->series.front(), {0, 2, 4, 6});
  EXPECT_EQ(scan->series.front().assessment.repairs.at(0),
            "only 4 of 7 phases were kept, because all of them would be larger than allowed");
  limits.most_voxels = std::uint64_t{12} * 10 * 20 - 1;
  scan = dicom::scan(source, limits);
  EXPECT_EQ(scan->series.front().assessment.code, "over_quota");
}

TEST(Case8, SplitsByThePrivateBValuesOfSiemensGeAndPhilips) {
  using Change = std::function<void(int phase, SliceSpec&)>;
  const auto text = [](SliceSpec& s, std::uint16_t group, std::uint16_t element, const char* vr,
                       const std::string& value) {
    s.extra.push_back({group, element, vr, value, {}});
  };
  const std::vector<std::pair<const char*, Change>> makers{
      {"Siemens",
       [&](int p, SliceSpec& s) {
         text(s, 0x0019, 0x0010, "LO", "SIEMENS MR HEADER");
         text(s, 0x0019, 0x100C, "IS", std::to_string(500 * p));
       }},
      {"GE",
       [&](int p, SliceSpec& s) {
         text(s, 0x0043, 0x0010, "LO", "GEMS_PARM_01");
         text(s, 0x0043, 0x1039, "IS", std::to_string(1'000'000'000 + 500 * p) + "\\8\\0\\0");
       }},
      {"Philips", [&](int p, SliceSpec& s) {
         text(s, 0x2001, 0x0010, "LO", "Philips Imaging DD 001");
         text(s, 0x2001, 0x1003, "FL", bytes_of_float(500.0F * static_cast<float>(p)));
       }}};
  for (const auto& [maker, change] : makers) {
    SCOPED_TRACE(maker);
    const Series series =
        series_of(files_of_phases(3, [&](int p, int z, SeriesSpec&, SliceSpec& s) {
          s.instance_number = 100 * (3 - p) + z;
          change(p, s);
          return true;
        }));
    expect_phases(series, {0, 1, 2});
    EXPECT_EQ(series.assessment.phases.at(2), (volume::Phase{PhaseKind::kBValue, 1000}));
  }
}

TEST(Case8, IgnoresPrivateElementsOfOtherCreators) {
  const Series series = series_of(files_of_phases(2, [](int p, int z, SeriesSpec&, SliceSpec& s) {
    s.extra.push_back({0x0019, 0x0010, "LO", "SOMEBODY ELSE", {}});
    s.extra.push_back({0x0019, 0x100C, "IS", std::to_string(500 * (1 - p)), {}});
    s.instance_number = 100 * p + z;
    return true;
  }));
  expect_phases(series, up_to(2));
  EXPECT_EQ(series.assessment.phases.at(1).kind, PhaseKind::kIndex);
}

TEST(Case8, IgnoresABValueOfTheWrongLength) {
  const Series series = series_of(files_of_phases(2, [](int p, int z, SeriesSpec&, SliceSpec& s) {
    s.extra.push_back({0x0018, 0x9087, "FD", bytes_of_double(-500.0 * p) + "1234", {}});
    s.instance_number = 100 * p + z;
    return true;
  }));
  expect_phases(series, up_to(2));
  EXPECT_EQ(series.assessment.phases.at(1).kind, PhaseKind::kIndex);
}

}  // namespace
}  // namespace diaphane::dicom
