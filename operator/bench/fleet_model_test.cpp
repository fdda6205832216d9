#include "operator/bench/fleet_model.h"

#include <gtest/gtest.h>

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

TEST(FleetModel, WithoutTroubleNobodyIsRefusedOrMovedAndAllDevicesServe) {
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

TEST(FleetModel, WithTroubleNoNodeIsOverCommitted) {
  Setting setting = small();
  setting.nodes_lost_per_second = setting.cordons_per_second = 0.05;
  FleetModel model(setting, Way::kLoad);
  const Figures figures = model.run();
  EXPECT_GT(figures.moves, 0);
  EXPECT_EQ(figures.over_committed, 0);
}

TEST(FleetModel, OneSessionADeviceLosesNothing) {
  Setting setting = small();
  setting.sessions = 60;
  setting.slots = 1;
  setting.crashes_per_second = setting.nodes_lost_per_second = setting.cordons_per_second = 0;
  EXPECT_NEAR(FleetModel(setting, Way::kLeastCount).run().lost, 0, 1e-9);
}

}  // namespace
}  // namespace diaphane::fleet::bench
