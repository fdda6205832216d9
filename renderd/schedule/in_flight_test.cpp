#include "renderd/schedule/in_flight.h"

#include <gtest/gtest.h>

namespace diaphane::render {
namespace {

using std::chrono::milliseconds;
const InFlight::Time kStart = InFlight::Time(std::chrono::hours(1));

TEST(InFlight, AFullDeviceHasOneMoreWaitingBehindAndAnEmptyOneTakesMany) {
  InFlight device;
  EXPECT_TRUE(room_for_another(device, true));
  device.begin(1, kStart);
  EXPECT_TRUE(room_for_another(device, true));
  device.begin(1, kStart);
  EXPECT_FALSE(room_for_another(device, true));
  device.rendered(1, kStart);
  EXPECT_TRUE(room_for_another(device, true)) << "its picture is no reason to wait";
  InFlight small;
  int taken = 0;
  for (; room_for_another(small, true); ++taken) small.begin(0.3, kStart);
  EXPECT_EQ(taken, 4) << "the fourth fills it";
}

TEST(InFlight, ADeviceWithoutAQueueIsFilledAndNoMore) {
  InFlight device;
  device.begin(0.6, kStart);
  EXPECT_TRUE(room_for_another(device, false));
  device.begin(0.6, kStart);
  EXPECT_FALSE(room_for_another(device, false));
  device.rendered(0.6, kStart + milliseconds(1));
  EXPECT_TRUE(room_for_another(device, false));
}

TEST(InFlight, TimeIsBusyWhileAnythingIsUnderWayAndFullBySum) {
  InFlight device;
  device.begin(1, kStart);
  device.begin(0.5, kStart + milliseconds(10));
  device.rendered(1, kStart + milliseconds(20));
  device.end(kStart + milliseconds(20));
  device.rendered(0.5, kStart + milliseconds(30));
  device.end(kStart + milliseconds(40));
  const auto later = kStart + milliseconds(100);
  EXPECT_NEAR(device.busy_seconds(later), 0.040, 1e-12);
  EXPECT_NEAR(device.fill_seconds(later), 0.010 + 0.015 + 0.005, 1e-12);
  EXPECT_EQ(device.filled(), 0);
}

TEST(InFlight, TwoThatFillTheDeviceHaveHalfOfTheirTimeEach) {
  EXPECT_EQ(own_share(2), 0.5);
  EXPECT_EQ(own_share(0.3), 1);
  EXPECT_EQ(own_share(1), 1);
}

}  // namespace
}  // namespace diaphane::render
