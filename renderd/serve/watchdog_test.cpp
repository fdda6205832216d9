#include "renderd/serve/watchdog.h"

#include <gtest/gtest.h>

#include "renderd/schedule/policy.h"
#include "renderd/schedule/runner.h"
#include "tests/support/renderd/eventually.h"
#include "tests/support/renderd/test_worker.h"

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;

// The watchdog's reports, from its thread.
struct HangReports {
  std::atomic<int> times{0};
  std::string name;
  Watchdog::Options within(std::chrono::milliseconds limit) {
    return {.limit = limit, .poll_interval = 10ms, .hung = [this](const std::string& who) {
              name = who;
              ++times;
            }};
  }
  bool soon() const {
    return eventually([this] { return times > 0; });
  }
};

TEST(Watchdog, ReportsSilenceOnceByNameAndSuspectsItBefore) {
  HangReports reports;
  std::atomic<std::uint64_t> lively{1};
  Watchdog watchdog({{"lively", [&] { return ++lively; }}, {"silent", [] { return 7; }}},
                    reports.within(200ms));
  EXPECT_FALSE(watchdog.suspects());
  ASSERT_TRUE(reports.soon());
  EXPECT_EQ(reports.name, "silent");
  EXPECT_TRUE(watchdog.suspects());
  std::this_thread::sleep_for(100ms);
  EXPECT_EQ(reports.times, 1);
}

TEST(Watchdog, IgnoresIdleAndProgressingWork) {
  HangReports reports;
  std::atomic<std::uint64_t> polls{1};
  std::atomic<bool> idle{false};
  // Progress is counted by polls, so that a busy machine delays both.
  Watchdog watchdog({{"one", [&]() -> std::uint64_t { return ++polls, idle ? 0 : polls / 2; }}},
                    reports.within(1s));
  const auto longer_than_the_limit = [&] {
    const auto end = std::chrono::steady_clock::now() + 1500ms;
    const std::uint64_t before = polls;
    return eventually(
        [&] { return std::chrono::steady_clock::now() > end && polls > before + 100; });
  };
  ASSERT_TRUE(longer_than_the_limit());
  idle = true;
  ASSERT_TRUE(longer_than_the_limit());
  EXPECT_EQ(reports.times, 0);
  EXPECT_FALSE(watchdog.suspects());
}

TEST(ProgressMonitor, TracksEachPieceOfWorkUntilItEnds) {
  ProgressMonitor monitor;
  ProgressMonitor::Work one(monitor);
  const std::uint64_t first = monitor.at(0);
  EXPECT_NE(first, 0U);
  {
    ProgressMonitor::Work two(monitor);
    EXPECT_NE(monitor.at(1), 0U);
    EXPECT_EQ(monitor.at(0), first) << "heartbeats of other work do not count";
  }
  EXPECT_EQ(monitor.at(1), 0U);
  one.heartbeat();
  EXPECT_NE(monitor.at(0), first);
}

// A client that always requests more.
struct Looker final : RenderClient {
  Looker() {
    request.scene = std::make_shared<const v1::Scene>();
    request.viewport = {64, 64};
    request.version = 1;
  }
  ViewRequest requested() override { return request; }
  std::uint64_t version() const noexcept override { return 1; }
  void began(std::uint64_t, const ViewRequest&) override {}
  void refused(const ViewRequest&, const Error&) override {}
  void rendered(const Batch&) override { ++batches; }
  void picture(RenderedPicture) override {}
  void failed(const Error&) override {}
  ViewRequest request;
  std::atomic<int> batches{0};
};

TEST(Watchdog, ReportsHungDeviceButNotALongQuantum) {
  auto device = std::make_shared<FakeDevice>();
  device->seconds_per_megapixel = 240;  // a sample of 64 x 64 takes a second
  FakeEngine engine(device);
  const SystemClock clock;
  Runner runner(make_policy(PolicyKind::kMarginalGain), clock, {});
  HangReports reports;
  Watchdog watchdog(watched(runner.progress()), reports.within(250ms));

  auto volume = std::make_shared<FakeDeviceVolume>(volume::Header{});
  auto looker = std::make_shared<Looker>();
  runner.add(looker, *engine.renderer(volume, 1, 0), 0);
  ASSERT_TRUE(eventually([&] { return looker->batches > 0; }));
  EXPECT_EQ(reports.times, 0) << "a quantum of one second is not a hang";

  device->hangs = true;
  EXPECT_TRUE(reports.soon());
  EXPECT_EQ(reports.name, "device");
  device->hangs = false;  // otherwise the runner's thread would never end
}

}  // namespace
}  // namespace diaphane::render
