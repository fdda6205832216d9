#include "bench/operator/lending_model.h"

#include <gtest/gtest.h>

#include "bench/operator/fleet_model.h"

namespace diaphane::fleet::bench {
namespace {

using Devices = std::vector<LendingModel::Device>;

Devices asked(const std::vector<double>& wants) {
  Devices devices;
  for (const double want : wants) devices.push_back({true, false, want});
  return devices;
}

double sum(const LendingModel& model, std::size_t count) {
  double all = 0;
  for (std::size_t i = 0; i < count; ++i) all += model.load(i);
  return all;
}

TEST(LendingModel, HelperAddsCapacityAfterOneSecondAtItsCost) {
  const LendingCosts costs;
  LendingModel model({}, costs, 1);
  const Devices devices = asked({1.3, 0.2});
  model.step(devices);
  EXPECT_DOUBLE_EQ(model.load(0), 1.3) << "the helper loads the volume";
  model.step(devices);
  EXPECT_NEAR(model.load(0), 1, 1e-6);
  EXPECT_NEAR(model.load(1), 0.2 + 0.3 / (1 - costs.handing - costs.merging), 1e-6);
}

TEST(LendingModel, HelpersLendOnlySpareCapacity) {
  LendingModel model({}, {}, 1);
  const Devices devices = asked({3, 2.5, 0.5, 0.6, 1.8});
  for (int second = 0; second < 10; ++second) {
    model.step(devices);
    for (const std::size_t helper : {2u, 3u}) EXPECT_LE(model.load(helper), 1 + 1e-9);
    for (const std::size_t busy : {0u, 1u, 4u}) EXPECT_GE(model.load(busy), 1 - 1e-9);
    EXPECT_GE(sum(model, devices.size()), 8.4 - 1e-9) << "helping makes no work less";
  }
  EXPECT_NEAR(model.lent(), 0.9, 0.01) << "all that is left";
}

TEST(LendingModel, LendsNothingWithoutOverload) {
  LendingModel model({}, {}, 1);
  const Devices devices = asked({1, 0.9, 0, 0.5});
  for (int second = 0; second < 5; ++second) model.step(devices);
  EXPECT_EQ(model.helpers(), 0u);
  for (std::size_t i = 0; i < devices.size(); ++i) {
    EXPECT_DOUBLE_EQ(model.load(i), devices[i].wants);
  }
}

TEST(LendingModel, DropsHelperThatLeaves) {
  LendingModel model({}, {}, 1);
  Devices devices = asked({1.5, 0.1});
  for (int second = 0; second < 3; ++second) model.step(devices);
  EXPECT_NEAR(model.load(0), 1, 1e-6);
  devices[1].there = false;
  model.step(devices);
  EXPECT_DOUBLE_EQ(model.load(0), 1.5);
  EXPECT_EQ(model.lent(), 0);
}

TEST(LendingModel, LendingHalvesTheLossesWithoutChangingPlacement) {
  Setting setting;
  setting.sessions = 1600;
  setting.devices = 128;
  setting.ramp_seconds = 60;
  setting.seconds = 60;
  const Figures alone = FleetModel(setting, Way::kLoad).run();
  const Figures lending = FleetModel(setting, Way::kLoadAndLending).run();
  EXPECT_EQ(lending.placings, alone.placings);
  EXPECT_EQ(lending.moves, alone.moves);
  EXPECT_EQ(lending.spread_of_stays, alone.spread_of_stays);
  EXPECT_LT(lending.lost, alone.lost / 2);
  EXPECT_LT(lending.spread, alone.spread);
  EXPECT_GT(lending.lent, 0);
}

}  // namespace
}  // namespace diaphane::fleet::bench
