#include "api/sessions/render_time.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/api/fake_placement.h"
#include "tests/support/api/fake_render_time_store.h"
#include "tests/support/api/refusals.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::int64_t kMinute = 60'000;

class RenderTimeTest : public testing::Test {
 protected:
  RenderTimeTest() { anna.user_id = "anna"; }
  RenderAccount& account() { return store.accounts["anna"]; }
  /// Lets the service poll every five seconds, as the API does.
  void look_for(std::chrono::seconds time) {
    for (auto passed = 0s; passed < time; passed += 5s) {
      clock.advance(5s);
      render_time.poll();
    }
  }

  Principal anna;
  ManualClock clock;
  FakeRenderTimeStore store;
  FakeSpentRenderTime spent;
  FakePlacement placement;
  RenderTime render_time{store, spent, placement, clock};
};

TEST_F(RenderTimeTest, ASessionIsOpenedOnlyWithTimeLeft) {
  account() = {.quota_ms = 1000, .used_ms = 999};
  EXPECT_TRUE(render_time.may_open(anna));
  account().used_ms = 1000;
  EXPECT_EQ(refusal(render_time.may_open(anna)), ProblemKind::kRenderTimeSpent);
  EXPECT_EQ(render_time.account("anna")->used_ms, 1000);
}

TEST_F(RenderTimeTest, TheRefusalNamesTheQuotaAndTheDayItResets) {
  using std::chrono::sys_days;
  using namespace std::chrono;
  for (const auto& [quota, month, words] :
       {std::tuple(0, February, "(0 minutes). It resets on 1 February."),
        std::tuple(1, January, "(1 minute). It resets on 1 January."),
        std::tuple(119, June, "(119 minutes). It resets on 1 June."),
        std::tuple(120, December, "(2 hours). It resets on 1 December."),
        std::tuple(600, May, "(10 hours). It resets on 1 May.")}) {
    account() = {.quota_ms = quota * kMinute,
                 .used_ms = 600 * kMinute,
                 .warned_at = clock.wall() - 1h,
                 .next_month = sys_days(2026y / month / 1)};
    EXPECT_THAT(render_time.may_open(anna).error().detail, HasSubstr(words));
    EXPECT_THAT(render_time.may_go_on(anna).error().detail, HasSubstr(words));
  }
}

TEST_F(RenderTimeTest, OpenSessionContinuesUntilTheGracePeriodEnds) {
  account() = {.quota_ms = 1000, .used_ms = 1000};
  EXPECT_TRUE(render_time.may_go_on(anna)) << "not warned yet";
  account().warned_at = clock.wall();
  clock.advance(2min - 1s);
  EXPECT_TRUE(render_time.may_go_on(anna));
  clock.advance(1s);
  EXPECT_EQ(refusal(render_time.may_go_on(anna)), ProblemKind::kRenderTimeSpent);
  account().quota_ms = 2000;
  EXPECT_TRUE(render_time.may_go_on(anna)) << "the quota was raised";
}

TEST_F(RenderTimeTest, AVisitorHasNoQuota) {
  store.away = true;
  EXPECT_TRUE(render_time.may_open({}));
  EXPECT_TRUE(render_time.may_go_on({}));
}

TEST_F(RenderTimeTest, ReportedTimeIsChargedOnce) {
  account() = {.quota_ms = 1000};
  spent.reported = {{"anna", 400}, {"nobody we know", 5}};
  look_for(20s);
  EXPECT_EQ(account().used_ms, 400);
  EXPECT_EQ(store.calls("add"), 1) << "there is nothing to add without a report";
  EXPECT_THAT(placement.ended, IsEmpty());
}

TEST_F(RenderTimeTest, SessionsOfAnAccountWithoutTimeEndAfterTheGracePeriod) {
  account() = {.quota_ms = 1000};
  store.accounts["bert"] = {.quota_ms = 10'000};
  spent.reported = {{"anna", 1000}, {"bert", 1000}};
  look_for(2min);
  EXPECT_THAT(placement.ended, IsEmpty());
  spent.reported = {{"anna", 10}};
  look_for(5s);
  EXPECT_THAT(placement.ended, ElementsAre("by anna")) << "once per poll, however it was found";
}

TEST_F(RenderTimeTest, IdleSessionsEndDuringAQuarterOfAnHourAfterTheGracePeriod) {
  account() = {.quota_ms = 1000, .used_ms = 1000};
  look_for(5s);
  EXPECT_EQ(account().warned_at, clock.wall()) << "a lower quota is noticed without a report";
  look_for(2min - 5s);
  EXPECT_THAT(placement.ended, IsEmpty());
  look_for(15min);
  const auto ended = placement.ended.size();
  EXPECT_EQ(ended, 180u);
  look_for(1min);
  EXPECT_LE(placement.ended.size(), ended + 1) << "they are not looked for for ever";
}

TEST_F(RenderTimeTest, ActiveSessionsEndRegardlessOfTheTimeOfTheWarning) {
  account() = {.quota_ms = 1000, .used_ms = 1000, .warned_at = clock.wall() - 48h};
  spent.reported = {{"anna", 10}};
  look_for(5s);
  EXPECT_THAT(placement.ended, ElementsAre("by anna"));
}

TEST_F(RenderTimeTest, OneFailureDoesNotKeepOtherSessionsOpen) {
  account() = {.quota_ms = 1000, .used_ms = 1000, .warned_at = clock.wall() - 5min};
  store.accounts["bert"] = account();
  spent.reported = {{"anna", 10}};
  store.break_function("add");
  placement.break_function("end_all_by");
  look_for(5s);
  EXPECT_EQ(placement.calls("end_all_by"), 2);
  store.repair("add");
  store.break_function("warned");
  placement.repair("end_all_by");
  spent.reported = {{"bert", 10}};
  look_for(5s);
  EXPECT_THAT(placement.ended, ElementsAre("by bert"));
}

TEST_F(RenderTimeTest, NothingIsChargedOrEndedWithoutTheReports) {
  account() = {.quota_ms = 1000, .used_ms = 1000, .warned_at = clock.wall() - 5min};
  spent.away = true;
  look_for(5s);
  EXPECT_EQ(store.calls("add") + store.calls("warned"), 0);
  EXPECT_THAT(placement.ended, IsEmpty());
}

TEST_F(RenderTimeTest, ReportsAnUnavailableDatabase) {
  expect_unavailable({
      {store, "account", [&] { return refusal(render_time.account("anna")); }},
      {store, "account", [&] { return refusal(render_time.may_open(anna)); }},
      {store, "account", [&] { return refusal(render_time.may_go_on(anna)); }},
  });
}

}  // namespace
}  // namespace diaphane::api
