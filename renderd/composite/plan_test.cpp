#include "renderd/composite/plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>

namespace diaphane::render {
namespace {

/// For any number of devices, of any speeds, some of which have gone, and any picture: each pixel
/// and each sample of the sequence is somebody's, and nobody else's.
TEST(SharesPlan, CoversEveryPixelAndEverySampleOnce) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 3'000; ++round) {
    const Canvas canvas{1 + static_cast<std::uint32_t>(random() % 4096),
                        1 + static_cast<std::uint32_t>(random() % 4096)};
    std::vector<double> speeds(1 + random() % 70);
    for (double& s : speeds) {
      s = random() % 4 == 0 ? 0 : std::exp2(static_cast<double>(random() % 20));
    }
    speeds[random() % speeds.size()] = 1;  // somebody is there
    RowCosts costs;
    for (int i = 0; i < 5; ++i) {
      const auto first = static_cast<std::uint32_t>(random() % canvas.height);
      costs.learn(first, canvas.height, canvas.height, 1e-3 * static_cast<double>(random() % 99),
                  0.05);
    }
    for (const Division division : {Division::kAverage, Division::kTiles}) {
      const auto shares = plan_shares(division, canvas, speeds, costs, 5);
      ASSERT_EQ(shares.size(), speeds.size());
      std::uint32_t next_row = 0;
      std::set<std::uint32_t> parts;
      for (std::size_t d = 0; d < shares.size(); ++d) {
        if (!(speeds[d] > 0)) {
          ASSERT_FALSE(shares[d]) << "it has gone";
        }
        if (!shares[d]) continue;
        const Share& share = *shares[d];
        ASSERT_EQ(share.sequence, 5u);
        ASSERT_TRUE(
            is_band(share.first_row, std::min(share.last_row, canvas.height), canvas.height));
        if (division == Division::kTiles) {
          ASSERT_EQ(share.first_row, next_row);
          ASSERT_EQ(share.parts, 1u);
          next_row = share.last_row;
        } else {
          ASSERT_TRUE(share.first_row == 0 && share.last_row >= canvas.height);
          ASSERT_TRUE(parts.insert(share.part).second);
          ASSERT_LT(share.part, share.parts);
        }
      }
      if (division == Division::kTiles) {
        ASSERT_EQ(next_row, canvas.height);
        const auto units = (canvas.height + kShareRows - 1) / kShareRows;
        const auto there =
            std::count_if(speeds.begin(), speeds.end(), [](double s) { return s > 0; });
        const auto dealt = std::count_if(shares.begin(), shares.end(),
                                         [](const auto& s) { return s.has_value(); });
        ASSERT_EQ(dealt, std::min<std::ptrdiff_t>(units, there));
      } else {
        for (const auto& share : shares) {
          if (share) {
            ASSERT_EQ(share->parts, parts.size());
          }
        }
      }
    }
  }
}

/// Bands take equally long, to a unit of rows.
TEST(SharesPlan, TilesAreSizedBySpeed) {
  const Canvas canvas{1280, 1600};
  const auto shares = plan_shares(Division::kTiles, canvas, {1, 2, 5}, {}, 0);
  EXPECT_NEAR(shares[0]->last_row, 200, kShareRows);
  EXPECT_NEAR(shares[1]->last_row, 600, kShareRows);
}

/// The middle rows cost ten times as much. After some pictures whose bands were measured, bands
/// take equally long within a fifth.
TEST(SharesPlan, TilesLearnWhatRowsCost) {
  const Canvas canvas{64, 1024};
  const auto seconds_of = [](std::uint32_t first, std::uint32_t last) {
    double sum = 0;
    for (std::uint32_t row = first; row < last; ++row) sum += row >= 384 && row < 640 ? 10 : 1;
    return sum;
  };
  const double whole = seconds_of(0, 1024);
  RowCosts costs;
  std::vector<double> took;
  for (int picture = 0; picture < 12; ++picture) {
    took.clear();
    for (const auto& share : plan_shares(Division::kTiles, canvas, {1, 1, 1, 1}, costs, 0)) {
      took.push_back(seconds_of(share->first_row, share->last_row));
      costs.learn(share->first_row, share->last_row, 1024, took.back(), whole);
    }
  }
  EXPECT_LT(*std::max_element(took.begin(), took.end()), 1.2 * whole / 4);
}

DivisionQuestion four_devices(Canvas canvas, double samples) {
  DivisionQuestion question;
  question.canvas = canvas;
  question.samples = samples;
  question.speeds = {1e8, 1e8, 1e8, 1e8};
  return question;
}

TEST(DivisionChoice, TilesMoveAsMuchLessAsThereAreDevices) {
  const auto question = four_devices({3840, 2160}, 64);
  const auto average = predict(Division::kAverage, question);
  const auto tiles = predict(Division::kTiles, question);
  EXPECT_GT(average.bytes_moved, 2 * tiles.bytes_moved);
  EXPECT_LT(tiles.seconds, average.seconds);
}

TEST(DivisionChoice, AFewSamplesOfALargePictureOverASlowWireAreTilesAndManyAreAnAverage) {
  auto few = four_devices({3840, 2160}, 4);
  EXPECT_EQ(choose_division(few), Division::kTiles);
  const auto many = four_devices({1280, 720}, 100'000);
  EXPECT_EQ(choose_division(many), Division::kAverage) << "all but no difference: the safe one";
  few.speeds[2] = 0;
  EXPECT_EQ(choose_division(few), Division::kAverage) << "bands need speeds";
  few.speeds = {1e8};
  EXPECT_EQ(choose_division(few), Division::kAverage);
}

TEST(Parts, AreHandedOverAtOnceThenWithEachFourthAndNeverForMoreThanAnEighthOfTheTime) {
  EXPECT_FALSE(part_due({.held = 1}));
  EXPECT_TRUE(part_due({.held = 2}));
  EXPECT_FALSE(part_due({.held = 2, .room = false}));
  EXPECT_FALSE(part_due({.held = 24, .delivered = 100, .seconds_since = 0.05}));
  EXPECT_TRUE(part_due({.held = 26, .delivered = 100, .seconds_since = 0.05}));
  EXPECT_TRUE(part_due({.held = 2, .delivered = 100, .seconds_since = 0.11}));
  EXPECT_FALSE(
      part_due({.held = 26, .delivered = 100, .seconds_since = 0.05, .seconds_cost = 0.01}));
}

TEST(Parts, NobodyRendersOnForWhoDoesNotTakeThem) {
  std::uint64_t held = 0;
  PartQuestion question{.held = 0, .delivered = 64, .seconds_since = 1, .room = false};
  while (may_render(question)) question.held = held += 2;
  EXPECT_EQ(held, 64u);
}

}  // namespace
}  // namespace diaphane::render
