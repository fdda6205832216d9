#include "renderd/session/slice_allowance.h"

#include <gtest/gtest.h>

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;

struct SliceAllowancesTest : testing::Test {
  /// Returns how many slices this viewer gets at once.
  int take_all(const std::string& who, bool guest = false) {
    int count = 0;
    while (allowances.take(who, guest, now)) ++count;
    return count;
  }
  SliceAllowances allowances;
  SliceAllowance::TimePoint now{1h};
};

TEST_F(SliceAllowancesTest, LimitSlicesPerSecondPerViewer) {
  EXPECT_EQ(take_all("a"), SliceAllowance::kMostASecond);
  EXPECT_EQ(take_all("b"), SliceAllowance::kMostASecond);
  now += 500ms;
  EXPECT_EQ(take_all("a"), SliceAllowance::kMostASecond / 2);
  now += 1h;
  EXPECT_EQ(take_all("a"), SliceAllowance::kMostASecond) << "idle time is not accumulated";
}

TEST_F(SliceAllowancesTest, ReduceTheRateAfterALongRun) {
  double count = 0;
  for (int second = 0; second < 1000; ++second, now += 1s) count += take_all("a");
  EXPECT_NEAR(count, SliceAllowance::kInARow + 1000 * SliceAllowance::kMostASecondThen, 150);
  EXPECT_LE(take_all("a"), SliceAllowance::kMostASecondThen);
}

TEST_F(SliceAllowancesTest, AreSharedByAllGuests) {
  int count = 0;
  for (int i = 0; i < 100; ++i) count += take_all("guest " + std::to_string(i), true);
  EXPECT_EQ(count, SliceAllowance::kGuestsTogether * SliceAllowance::kMostASecond);
  EXPECT_EQ(take_all("owner"), SliceAllowance::kMostASecond)
      << "guests do not use the owner's allowance";
}

TEST_F(SliceAllowancesTest, ChargeSlabsForTheirSamples) {
  constexpr std::uint64_t kToken = 512 * 512;
  ASSERT_TRUE(allowances.take("a", true, now));
  allowances.charge("a", true, kToken / 2);
  EXPECT_EQ(take_all("a", true), SliceAllowance::kMostASecond - 1) << "as cheap as a stored slice";
  now += 1s;
  ASSERT_TRUE(allowances.take("a", true, now));
  allowances.charge("a", true, 240 * kToken);
  EXPECT_EQ(take_all("a", true), 0);
  now += 900ms;
  EXPECT_EQ(take_all("a", true), 0) << "the debt of 120 slices lasts a second";
  now += 200ms;
  EXPECT_GT(take_all("a", true), 0);
}

TEST_F(SliceAllowancesTest, DoNotGrowWithTheNumberOfNames) {
  int count = 0;
  for (int i = 0; i < 2000; ++i) count += take_all("name " + std::to_string(i));
  EXPECT_EQ(count, (SliceAllowances::kMostViewers + 1) * SliceAllowance::kMostASecond);
}

}  // namespace
}  // namespace diaphane::render
