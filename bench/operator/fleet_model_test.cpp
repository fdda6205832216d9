#include "bench/operator/fleet_model.h"

#include <gtest/gtest.h>

#include <cmath>

namespace diaphane::fleet::bench {
namespace {

Setting small() {
  Setting setting;
  setting.sessions = 600;
  setting.devices = 64;
  setting.ramp_seconds = 20;
  setting.seconds = 120;
  return setting;
}

TEST(FleetModel, NeitherRefusesNorMovesSessionsWithoutFaults) {
  Setting setting = small();
  setting.crashes_per_second = setting.nodes_lost_per_second = setting.cordons_per_second = 0;
  for (const Way way : {Way::kLoad, Way::kRoundRobin, Way::kLeastCount}) {
    FleetModel model(setting, way);
    const Figures figures = model.run();
    EXPECT_EQ(model.world().workers.size(), 64u);
    EXPECT_EQ(figures.refused, 0);
    EXPECT_EQ(figures.moves, 0);
    EXPECT_EQ(figures.over_committed, 0);
    EXPECT_EQ(figures.plan_seconds.size(), 120u);
    EXPECT_GT(figures.lost, 0);
  }
}

TEST(FleetModel, OvercommitsNoNodeDuringFaults) {
  Setting setting = small();
  setting.nodes_lost_per_second = setting.cordons_per_second = 0.05;
  FleetModel model(setting, Way::kLoad);
  const Figures figures = model.run();
  EXPECT_GT(figures.moves, 0);
  EXPECT_EQ(figures.over_committed, 0);
}

TEST(FleetModel, PlacesByExpectedLoadMoreEvenlyThanByCount) {
  // Ten pairs of runs with the same faults. If the policies were equal, the mean difference would
  // exceed 4.3 times its own standard deviation once in a thousand (Student, 9 degrees of freedom).
  constexpr int kPairs = 10;
  double sum = 0, squares = 0;
  for (std::uint64_t seed = 1; seed <= kPairs; ++seed) {
    Setting setting = small();
    setting.devices = 128;
    setting.sessions = 1600;
    setting.ramp_seconds = 120;
    setting.seed = seed;
    const double better = FleetModel(setting, Way::kLeastCount).run().spread_of_stays -
                          FleetModel(setting, Way::kLoad).run().spread_of_stays;
    sum += better;
    squares += better * better;
  }
  const double mean = sum / kPairs;
  const double variance = (squares / kPairs - mean * mean) / (kPairs - 1);
  EXPECT_GT(mean, 4.3 * std::sqrt(variance)) << mean;
}

TEST(FleetModel, LosesNothingWithOneSessionPerDevice) {
  Setting setting = small();
  setting.sessions = 60;
  setting.slots = 1;
  setting.crashes_per_second = setting.nodes_lost_per_second = setting.cordons_per_second = 0;
  EXPECT_NEAR(FleetModel(setting, Way::kLeastCount).run().lost, 0, 1e-9);
}

}  // namespace
}  // namespace diaphane::fleet::bench
