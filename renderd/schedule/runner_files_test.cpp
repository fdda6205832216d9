// Stills for files rendered beside sessions, to which they yield.

#include <gtest/gtest.h>

#include <future>

#include "renderd/schedule/marginal_gain.h"
#include "renderd/schedule/runner.h"
#include "tests/support/renderd/eventually.h"
#include "tests/support/renderd/fake_engine.h"
#include "tests/support/renderd/held_clock.h"
#include "tests/support/renderd/test_client.h"

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;

struct RunnerFilesTest : testing::Test {
  /// A job on the device `files`, which determines the time per sample.
  StillJob job(StillRank rank, std::promise<double>& done, std::uint32_t samples = 10) {
    StillJob job;
    job.scene = std::make_shared<const v1::Scene>();
    job.canvas = {64, 64};
    job.samples = samples;
    job.rank = rank;
    job.renderer = std::make_shared<FakeRenderer>(files, nullptr);
    job.took = [this](double seconds) { charged += seconds; };
    job.done = [&done](Result<PictureRgb8> picture, double error) {
      done.set_value(picture ? error : -1);
    };
    return job;
  }
  std::shared_ptr<TestClient> person() {
    auto made = std::make_shared<TestClient>(clock, Canvas{64, 64});
    runner.add(made, std::make_unique<FakeRenderer>(sessions, nullptr), 0);
    return made;
  }
  std::shared_ptr<FakeDevice> sessions = std::make_shared<FakeDevice>();
  std::shared_ptr<FakeDevice> files = std::make_shared<FakeDevice>();
  std::atomic<double> charged{0};
  HeldClock clock;
  Runner runner{std::make_unique<MarginalGain>(MarginalGain::Options()), clock,
                Runner::Options{.rules = {0.01, 4, 1 << 20}}};
};

TEST_F(RunnerFilesTest, FilePausesWhileASessionMoves) {
  files->seconds_per_megapixel = 250'000;  // minutes per sample unless interrupted
  sessions->seconds_per_megapixel = 0.1;
  std::promise<double> done;
  auto finished = done.get_future();
  runner.submit(job(StillRank::kFile, done));
  ASSERT_TRUE(eventually([&] { return files->rendering > 0; }));
  clock.hold();  // the session moves until the clock is released
  const auto one = person();
  runner.wake();
  ASSERT_TRUE(eventually([&] { return !one->pictures().empty() && files->rendering == 0; }))
      << "the sample in flight is interrupted";
  int beside = 0;
  for (int i = 0; i < 50; ++i) {
    one->turn(i + 2);
    runner.wake();
    std::this_thread::sleep_for(5ms);
    beside += files->rendering;
  }
  EXPECT_EQ(beside, 0);
  EXPECT_EQ(files->samples, 0u);
  files->seconds_per_megapixel = 1;
  clock.release();
  ASSERT_EQ(finished.wait_for(60s), std::future_status::ready);
  EXPECT_NEAR(finished.get(), 0.5 / std::sqrt(10.0), 1e-9);
  EXPECT_GT(charged, 0.03) << "ten samples of 4 ms, to whom asked for them";
  EXPECT_EQ(files->scenes, 1) << "a renderer can continue the sample that was interrupted";
}

TEST_F(RunnerFilesTest, LaterStillsOvertakeAFile) {
  files->seconds_per_megapixel = 1;
  std::promise<double> file, background, awaited;
  auto ended_file = file.get_future(), ended_background = background.get_future(),
       ended_awaited = awaited.get_future();
  runner.submit(job(StillRank::kFile, file, 1000));
  ASSERT_TRUE(eventually([&] { return files->samples > 0; }));
  runner.submit(job(StillRank::kBackground, background, 200));
  runner.submit(job(StillRank::kAwaited, awaited, 10));
  ASSERT_EQ(ended_awaited.wait_for(60s), std::future_status::ready);
  EXPECT_EQ(ended_background.wait_for(0s), std::future_status::timeout);
  ASSERT_EQ(ended_background.wait_for(60s), std::future_status::ready);
  EXPECT_EQ(ended_file.wait_for(0s), std::future_status::timeout);
  files->seconds_per_megapixel = 0;
  EXPECT_EQ(ended_file.wait_for(60s), std::future_status::ready);
}

TEST_F(RunnerFilesTest, SessionsContinueWhileAFileIsFinished) {
  const auto one = person();
  ASSERT_TRUE(eventually([&] { return !one->pictures().empty(); }));
  files->holds_pictures = true;
  std::promise<double> done;
  auto finished = done.get_future();
  StillJob large = job(StillRank::kFile, done);
  large.smoothed = true;
  runner.submit(std::move(large));
  ASSERT_TRUE(eventually([&] { return files->making_pictures > 0; }));
  const std::uint64_t samples = one->samples;
  const std::size_t pictures = one->pictures().size();
  one->turn(2);
  runner.wake();
  EXPECT_TRUE(
      eventually([&] { return one->samples > samples && one->pictures().size() > pictures; }));
  const auto late = person();  // a session that starts meanwhile
  EXPECT_TRUE(eventually([&] { return !late->pictures().empty(); }));
  EXPECT_EQ(finished.wait_for(0s), std::future_status::timeout);
  files->holds_pictures = false;
  ASSERT_EQ(finished.wait_for(60s), std::future_status::ready);
  EXPECT_GT(finished.get(), 0);
}

TEST_F(RunnerFilesTest, CancelledFileIsDroppedAndTheNextIsRendered) {
  files->holds_pictures = true;
  std::promise<double> left, stays;
  auto to_who_left = left.get_future(), to_who_stays = stays.get_future();
  std::atomic<bool> cancelled{false};
  StillJob cut = job(StillRank::kFile, left);
  cut.cancelled = [&] { return cancelled.load(); };
  const std::weak_ptr<FrameRenderer> of_who_left = cut.renderer;
  runner.submit(std::move(cut));
  ASSERT_TRUE(eventually([&] { return files->making_pictures > 0; }));
  runner.submit(job(StillRank::kFile, stays));
  cancelled = true;
  files->holds_pictures = false;
  ASSERT_EQ(to_who_stays.wait_for(60s), std::future_status::ready);
  EXPECT_GT(to_who_stays.get(), 0);
  EXPECT_TRUE(eventually([&] { return of_who_left.expired(); }));
  EXPECT_EQ(to_who_left.wait_for(0s), std::future_status::timeout);
}

TEST_F(RunnerFilesTest, StopWaitsForTheFileBeingFinished) {
  files->holds_pictures = true;
  std::promise<double> done;
  auto finished = done.get_future();
  runner.submit(job(StillRank::kFile, done));
  ASSERT_TRUE(eventually([&] { return files->making_pictures > 0; }));
  auto stopped = std::async(std::launch::async, [&] { runner.stop(); });
  EXPECT_EQ(finished.wait_for(0s), std::future_status::timeout);
  files->holds_pictures = false;
  stopped.get();
  ASSERT_EQ(finished.wait_for(0s), std::future_status::ready);
  EXPECT_GT(finished.get(), 0);
}

TEST_F(RunnerFilesTest, CancelledFileIsInterruptedAndReleased) {
  files->seconds_per_megapixel = 250'000;
  std::promise<double> done;
  std::atomic<bool> cancelled{false};
  StillJob cut = job(StillRank::kFile, done);
  cut.cancelled = [&] { return cancelled.load(); };
  const std::weak_ptr<FrameRenderer> left = cut.renderer;
  runner.submit(std::move(cut));
  ASSERT_TRUE(eventually([&] { return files->rendering > 0; }));
  cancelled = true;
  EXPECT_TRUE(eventually([&] { return left.expired(); }));
  EXPECT_EQ(done.get_future().wait_for(0s), std::future_status::timeout);
}

}  // namespace
}  // namespace diaphane::render
