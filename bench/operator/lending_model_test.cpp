#include "bench/operator/lending_model.h"

#include <gtest/gtest.h>

#include <string>

#include "bench/operator/fleet_model.h"
#include "renderd/composite/plan.h"

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

LendingRules with_spare(std::size_t most) {
  LendingRules rules;
  rules.most = rules.most_spare = most;
  return rules;
}

/// A kind of device, the look that is slowest on it at 1280x720, and how parts reach a neighbour.
struct Kind {
  const char* name;
  double speed;    ///< pixel samples per second
  double samples;  ///< per pixel, for an error of 1%
  double bytes_per_second;
};
/// An H200 takes 97.9 ms to 5% and 25 times as long to 1% (docs/figures.md, `convergence`).
constexpr Kind kHostGpus{"gpus_of_one_host", 128e6, 340, 1e12};
constexpr Kind kRemoteGpus{"gpus_on_100_gbit", 128e6, 340, 12e9};
constexpr Kind kCores{"two_cores_on_10_gbit", 0.5e6, 340, 1.2e9};

/// Returns the seconds until the picture has its samples, with helpers that give these shares.
double seconds_with(const std::vector<double>& shares, const Kind& kind) {
  render::DivisionInput input;
  input.canvas = {1280, 720};
  input.samples = kind.samples;
  input.bytes_per_second = kind.bytes_per_second;
  input.speeds.push_back(kind.speed);
  for (const double share : shares) input.speeds.push_back(kind.speed * share);
  return render::predict(render::choose_division(input), input).seconds;
}

TEST(LendingModel, LonePersonGetsTheWholeIdleFleet) {
  for (const std::size_t devices : {2u, 4u, 8u}) {
    LendingModel model(with_spare(7), {}, 1);
    std::vector<double> wants(devices);
    wants[0] = 1;
    for (int second = 0; second < 4; ++second) model.step(asked(wants));
    ASSERT_EQ(model.spare(0).size(), devices - 1);
    EXPECT_EQ(model.load(0), 1) << "nothing is needed";
    for (const Kind& kind : {kHostGpus, kCores, kRemoteGpus}) {
      const double ratio = seconds_with(model.spare(0), kind) / seconds_with({}, kind);
      const double of_ideal = ratio * static_cast<double>(devices);
      RecordProperty(kind.name + ("_" + std::to_string(devices)), std::to_string(of_ideal));
      // Eight remote GPUs spend a quarter of the time on receiving their parts.
      const bool too_far = kind.name == kRemoteGpus.name && devices == 8;
      EXPECT_LE(of_ideal, too_far ? 1.5 : 1.25) << devices << " " << kind.name;
    }
  }
}

TEST(LendingModel, SpareTimeYieldsToNeed) {
  LendingModel with(with_spare(3), {}, 1);
  LendingModel without({}, {}, 1);
  // The first is alone with its device, the second is overloaded, and the third is idle.
  const Devices devices = asked({1, 1.5, 0.2});
  for (int second = 0; second < 10; ++second) {
    with.step(devices);
    without.step(devices);
  }
  EXPECT_DOUBLE_EQ(with.load(1), without.load(1));
  ASSERT_EQ(with.spare(0).size(), 1u);
  EXPECT_LT(with.spare(0)[0], 0.3) << "what the overloaded device leaves";
}

Setting small_fleet() {
  Setting setting;
  setting.sessions = 1600;
  setting.devices = 128;
  setting.ramp_seconds = 60;
  setting.seconds = 60;
  return setting;
}

TEST(LendingModel, SpareTimeDelaysNobody) {
  Setting setting = small_fleet();
  double needed = 0, spare = 0;
  for (setting.seed = 1; setting.seed <= 8; ++setting.seed) {
    setting.lending.most_spare = 0;
    const Figures without = FleetModel(setting, Way::kLoadAndLending).run();
    setting.lending.most_spare = setting.lending.most;
    const Figures with = FleetModel(setting, Way::kLoadAndLending).run();
    EXPECT_EQ(with.placings, without.placings);
    needed += without.lost;
    spare += with.lost;
  }
  RecordProperty("ratio", std::to_string(spare / needed));
  EXPECT_LT(spare, 1.05 * needed);
}

TEST(LendingModel, LendingHalvesTheLossesWithoutChangingPlacement) {
  Setting setting = small_fleet();
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
