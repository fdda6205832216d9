#include "renderd/schedule/in_flight.h"

#include <gtest/gtest.h>

namespace diaphane::render {
namespace {

using std::chrono::milliseconds;
const InFlight::Time kStart = InFlight::Time(std::chrono::hours(1));

TEST(InFlight, FullDeviceAcceptsOneMoreAndEmptyDeviceMany) {
  InFlight device;
  EXPECT_TRUE(room_for_another(device, true));
  device.begin(1, kStart);
  EXPECT_TRUE(room_for_another(device, true));
  device.begin(1, kStart);
  EXPECT_FALSE(room_for_another(device, true));
  device.rendered(1, kStart);
  EXPECT_TRUE(room_for_another(device, true)) << "its picture is not a reason to wait";
  InFlight small;
  int taken = 0;
  for (; room_for_another(small, true); ++taken) small.begin(0.3, kStart);
  EXPECT_EQ(taken, 4) << "the fourth fills it";
}

TEST(InFlight, FillsADeviceWithoutAQueueExactly) {
  InFlight device;
  device.begin(0.6, kStart);
  EXPECT_TRUE(room_for_another(device, false));
  device.begin(0.6, kStart);
  EXPECT_FALSE(room_for_another(device, false));
  device.rendered(0.6, kStart + milliseconds(1));
  EXPECT_TRUE(room_for_another(device, false));
}

TEST(InFlight, CountsBusyTimeWhileAnyQuantumRuns) {
  InFlight device;
  device.begin(1, kStart);
  device.begin(0.5, kStart + milliseconds(10));
  device.rendered(1, kStart + milliseconds(20));
  device.end(kStart + milliseconds(20));
  device.rendered(0.5, kStart + milliseconds(30));
  device.end(kStart + milliseconds(40));
  EXPECT_NEAR(device.busy_seconds(kStart + milliseconds(100)), 0.040, 1e-12);
  EXPECT_EQ(device.filled(), 0);
}

TEST(InFlight, TimeOfSpareQuantaAloneIsNotNeeded) {
  InFlight device;
  const auto at = [](int ms) { return kStart + milliseconds(ms); };
  device.begin(1, at(0), 0, true);
  EXPECT_NEAR(device.needed_seconds(at(10)), 0, 1e-12) << "also while it is in flight";
  device.begin(1, at(10));
  device.end(at(30));
  device.end(at(60), 0, true);
  EXPECT_NEAR(device.needed_seconds(at(100)), 0.020, 1e-12);
  EXPECT_NEAR(device.busy_seconds(at(100)), 0.060, 1e-12);
}

TEST(InFlight, ChargesAddUpToTheBusyTime) {
  InFlight device;
  const auto at = [](int ms) { return kStart + milliseconds(ms); };
  device.begin(1, at(0));
  const double first = device.own_seconds(at(0));
  device.begin(1, at(10));
  const double second = device.own_seconds(at(10));
  const double first_had = device.own_seconds(at(30)) - first;
  device.end(at(30));
  const double second_had = device.own_seconds(at(35)) - second;
  device.end(at(35));
  EXPECT_NEAR(first_had, 0.010 + 0.020 / 2, 1e-12);
  EXPECT_NEAR(second_had, 0.020 / 2 + 0.005, 1e-12);
  EXPECT_NEAR(first_had + second_had, device.busy_seconds(at(100)), 1e-12);
  const double after = device.own_seconds(at(100));
  EXPECT_EQ(device.own_seconds(at(200)), after) << "nobody has what is idle";
}

TEST(InFlight, PausedQuantumIsNotCharged) {
  InFlight device;
  const auto at = [](int ms) { return kStart + milliseconds(ms); };
  device.begin(1, at(0));
  const double long_one = device.own_seconds(at(0));
  device.begin(1, at(10), 2);
  const double middle = device.own_seconds(at(10), 2);
  device.begin(1, at(20), 5);
  const double urgent = device.own_seconds(at(20), 5);
  EXPECT_EQ(device.highest(), 5U);
  EXPECT_NEAR(device.own_seconds(at(30), 5) - urgent, 0.010, 1e-12);
  device.end(at(30), 5);
  EXPECT_EQ(device.highest(), 2U);
  EXPECT_NEAR(device.own_seconds(at(35), 2) - middle, 0.010 + 0.005, 1e-12);
  device.end(at(35), 2);
  EXPECT_EQ(device.highest(), 0U);
  EXPECT_NEAR(device.own_seconds(at(100)) - long_one, 0.010 + 0.065, 1e-12);
}

TEST(InFlight, RaisedQuantumKeepsItsDeviceTime) {
  InFlight device;
  const auto at = [](int ms) { return kStart + milliseconds(ms); };
  device.begin(1, at(0));
  device.begin(1, at(10), 4);
  EXPECT_NEAR(device.own_seconds(at(30)), 0.010, 1e-12) << "it pauses";
  const double before_raise = device.raise(at(30), 0, 6);
  EXPECT_EQ(device.highest(), 6U);
  EXPECT_NEAR(before_raise + device.own_seconds(at(30), 6), 0.010, 1e-12);
  EXPECT_NEAR(before_raise + device.own_seconds(at(35), 6), 0.015, 1e-12);
  device.end(at(35), 6);
  EXPECT_EQ(device.highest(), 4U);
  device.end(at(40), 4);
  EXPECT_EQ(device.count(), 0U);
}

}  // namespace
}  // namespace diaphane::render
