#include "renderd/schedule/runner.h"

#include <gtest/gtest.h>

#include <future>

#include "renderd/schedule/canvas.h"
#include "renderd/schedule/marginal_gain.h"
#include "renderd/schedule/round_robin.h"
#include "tests/support/renderd/eventually.h"
#include "tests/support/renderd/fake_engine.h"
#include "tests/support/renderd/test_client.h"

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

struct RunnerTest : testing::Test {
  std::shared_ptr<FakeDevice> device = std::make_shared<FakeDevice>();
  SystemClock clock;
  std::atomic<int> lost{0};
  Runner runner{
      std::make_unique<RoundRobin>(), clock,
      Runner::Options{.rules = {0.1, 4, 1 << 20}, .device_lost = [this](const Error&) { ++lost; }}};

  std::shared_ptr<TestClient> viewer(Canvas viewport = {100, 100}) {
    auto made = std::make_shared<TestClient>(clock, viewport);
    handle = runner.add(made, std::make_unique<FakeRenderer>(device, nullptr), 1000);
    return made;
  }
  std::uint64_t handle = 0;
};

TEST_F(RunnerTest, ConvergedImageUsesNoMoreTime) {
  device->seconds_per_megapixel = 0.1;  // 1 ms per sample
  const auto one = viewer();
  ASSERT_TRUE(eventually([&] {
    const auto pictures = one->pictures();
    return !pictures.empty() && pictures.back().info.converged && !pictures.back().info.moving;
  }));
  const auto pictures = one->pictures();
  EXPECT_EQ(pictures.front().info.samples, 1U);
  EXPECT_TRUE(pictures.front().info.first_of_epoch);
  EXPECT_LE(pictures.back().info.error, 0.1);
  for (std::size_t i = 1; i < pictures.size(); ++i) {
    EXPECT_GE(pictures[i].info.epoch, pictures[i - 1].info.epoch);
    if (pictures[i].info.epoch == pictures[i - 1].info.epoch) {
      EXPECT_GE(pictures[i].info.samples, pictures[i - 1].info.samples);
    }
  }
  const std::uint64_t samples = device->samples;
  std::this_thread::sleep_for(100ms);
  EXPECT_EQ(device->samples, samples);
}

TEST_F(RunnerTest, HiddenSessionUsesNoTime) {
  const auto one = viewer();
  one->show(false);
  runner.wake();
  ASSERT_TRUE(eventually([&] { return runner.busy_seconds() >= 0; }));
  std::this_thread::sleep_for(50ms);
  const std::uint64_t samples = device->samples;
  one->turn(2);
  runner.wake();
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(device->samples, samples);
  one->show(true);
  runner.wake();
  EXPECT_TRUE(eventually([&] { return device->last_eye_x == 2; }));
}

TEST_F(RunnerTest, SpareTimeIsUsedOnlyWhileNoOtherImageGains) {
  Runner endless(std::make_unique<MarginalGain>(), clock,
                 Runner::Options{.rules = {1e-6, 4, 1 << 20}});
  device->seconds_per_megapixel = 0.1;
  const auto own = std::make_shared<TestClient>(clock);
  const auto spare = std::make_shared<TestClient>(clock);
  spare->spare = true;
  endless.add(own, std::make_unique<FakeRenderer>(device, nullptr), 1);
  ASSERT_TRUE(eventually([&] { return own->samples > 4; }));
  endless.add(spare, std::make_unique<FakeRenderer>(device, nullptr), 1000);
  const auto own_continues = [&] {
    const std::uint64_t samples = own->samples;
    return eventually([&] { return own->samples > samples + 100; });
  };
  ASSERT_TRUE(own_continues());
  EXPECT_EQ(spare->samples, 0U);
  own->show(false);
  endless.wake();
  ASSERT_TRUE(eventually([&] { return spare->samples > 10; }));
  const double load = endless.busy_seconds(), busy = endless.times().busy;
  ASSERT_TRUE(eventually([&] { return endless.times().busy > busy + 0.05; }));
  EXPECT_EQ(endless.busy_seconds(), load) << "spare time does not count as load";
  own->show(true);
  endless.wake();
  ASSERT_TRUE(own_continues());  // quanta in flight end meanwhile
  const std::uint64_t samples = spare->samples;
  ASSERT_TRUE(own_continues());
  EXPECT_EQ(spare->samples, samples);
  endless.stop();
}

TEST_F(RunnerTest, ImagesCarryTheirInputAndRisingEpochs) {
  const auto one = viewer();
  ASSERT_TRUE(eventually([&] { return !one->pictures().empty(); }));
  for (int turn = 2; turn <= 20; ++turn) {
    one->turn(turn);
    runner.wake();
    ASSERT_TRUE(eventually([&] {
      const auto pictures = one->pictures();
      return pictures.back().info.input_seq == static_cast<std::uint64_t>(turn);
    }));
  }
  std::uint64_t epoch = 1000;
  for (const RenderedPicture& picture : one->pictures()) {
    EXPECT_GE(picture.info.epoch, epoch);
    epoch = picture.info.epoch;
    // The shade encodes the camera's x, so this checks that every picture shows the scene of its
    // input number.
    EXPECT_EQ(picture.picture.pixels.front(), picture.info.input_seq);
  }
  EXPECT_GT(epoch, 1000U);
}

TEST_F(RunnerTest, InputInterruptsRefinement) {
  device->seconds_per_megapixel = 1;
  const auto one = viewer({200, 200});  // 40 ms per sample at rest
  ASSERT_TRUE(eventually([&] { return one->samples > 12; }));
  std::this_thread::sleep_for(kRestSeconds * 1.2s);
  device->seconds_per_megapixel = 100;  // the sample in flight takes 4 s
  std::this_thread::sleep_for(60ms);
  device->seconds_per_megapixel = 100;
  one->turn(7);
  const auto asked = steady_clock::now();
  device->seconds_per_megapixel = 1;
  runner.wake();
  ASSERT_TRUE(eventually([&] {
    const auto pictures = one->pictures();
    return !pictures.empty() && pictures.back().info.input_seq == 2;
  }));
  EXPECT_LT(steady_clock::now() - asked, 1s);
}

TEST_F(RunnerTest, FirstImageOvertakesALongSample) {
  Runner overtaking(std::make_unique<MarginalGain>(), clock,
                    Runner::Options{.rules = {1e-6, 4, 1 << 20}});
  device->seconds_per_megapixel = 0.01;
  const auto slow = std::make_shared<TestClient>(clock, Canvas{200, 200});
  const auto quick = std::make_shared<TestClient>(clock, Canvas{16, 16});
  const auto slow_handle = overtaking.add(slow, std::make_unique<FakeRenderer>(device, nullptr), 1);
  overtaking.add(quick, std::make_unique<FakeRenderer>(device, nullptr), 1000);
  ASSERT_TRUE(eventually([&] { return !slow->pictures().empty() && !quick->pictures().empty(); }));
  quick->show(false);
  overtaking.wake();
  std::this_thread::sleep_for(kRestSeconds * 2s);
  device->seconds_per_megapixel = 1e5;  // the next sample takes an hour
  std::uint64_t samples = 0;
  ASSERT_TRUE(eventually([&] {
    samples = slow->samples;
    std::this_thread::sleep_for(100ms);  // longer than a quantum that was begun at the old cost
    return device->rendering == 1 && slow->samples == samples;
  }));
  // 20 ms per picture, after which a drag leaves the device to others for some milliseconds. The
  // third picture becomes due without another wake().
  device->seconds_per_megapixel = 80;
  quick->show(true);
  for (std::uint64_t turn = 2; turn <= 3; ++turn) {
    quick->turn(static_cast<double>(turn));
    overtaking.wake();
    ASSERT_TRUE(eventually([&] { return quick->pictures().back().info.input_seq == turn; }));
  }
  quick->turn_and_rest(4);
  overtaking.wake();
  EXPECT_TRUE(eventually([&] { return quick->pictures().back().info.input_seq == 4; }));
  EXPECT_EQ(slow->samples, samples);
  overtaking.remove(slow_handle);
}

TEST_F(RunnerTest, NewerInputRaisesThePrecedenceOfWorkInFlight) {
  const auto one = viewer();
  ASSERT_TRUE(eventually([&] { return !one->pictures().empty() && runner.waiting() == 0; }));
  device->holds_pictures = true;
  one->again();
  runner.wake();
  ASSERT_TRUE(eventually([&] { return device->making_pictures == 1; }));
  EXPECT_EQ(device->precedence, 0U);
  EXPECT_EQ(device->raised_to, 0U);
  one->turn(2);
  runner.wake();
  EXPECT_TRUE(eventually([&] { return device->raised_to > 0; }));
  device->holds_pictures = false;
  EXPECT_TRUE(eventually([&] { return device->last_eye_x == 2; }));
}

TEST_F(RunnerTest, ShowsImagesDuringADragFasterThanTheDevice) {
  device->seconds_per_megapixel = 2;
  const auto one = viewer({200, 200});  // 80 ms per sample, an input every 10 ms
  const auto end = steady_clock::now() + 1s;
  while (steady_clock::now() < end) {
    one->turn(steady_clock::now().time_since_epoch().count() % 1000);
    runner.wake();
    std::this_thread::sleep_for(10ms);
  }
  const auto pictures = one->pictures();
  // Twelve would fit; a busy test machine achieves at least half of that.
  EXPECT_GE(pictures.size(), 6U);
  for (const RenderedPicture& picture : pictures) EXPECT_TRUE(picture.info.moving);
}

TEST_F(RunnerTest, ReducesOnlyTheMovingImageOnASlowDevice) {
  device->seconds_per_megapixel = 8;  // 320 ms for the whole viewport
  const auto one = viewer({200, 200});
  ASSERT_TRUE(eventually([&] { return one->samples >= 1; }));
  for (int i = 0; i < 30; ++i) {
    one->turn(i);
    runner.wake();
    std::this_thread::sleep_for(20ms);
  }
  const RenderedPicture moving = one->pictures().back();
  EXPECT_LT(moving.picture.size.width, 200U);
  EXPECT_TRUE(moving.info.moving);
  ASSERT_TRUE(eventually([&] { return one->pictures().back().picture.size == Canvas{200, 200}; }));
  EXPECT_FALSE(one->pictures().back().info.moving);
  EXPECT_GT(one->pictures().back().info.epoch, moving.info.epoch);
}

TEST_F(RunnerTest, SessionsShareTheDeviceEvenly) {
  device->seconds_per_megapixel = 0.2;  // 2 ms per sample
  const auto one = viewer();
  const auto two = viewer();
  const auto three = viewer();
  ASSERT_TRUE(eventually([&] { return one->samples + two->samples + three->samples > 30; }));
  const double mean = double(one->samples + two->samples + three->samples) / 3;
  for (const auto& each : {one, two, three}) EXPECT_NEAR(double(each->samples), mean, 0.7 * mean);
}

TEST_F(RunnerTest, RefusedSceneKeepsTheImageUntilTheNextScene) {
  const auto one = viewer();
  ASSERT_TRUE(eventually([&] { return !one->pictures().empty(); }));
  device->refuse_scenes = true;
  const std::uint64_t epoch = one->began_epoch;
  one->turn(5);
  runner.wake();
  ASSERT_TRUE(eventually([&] { return one->refusal_count() == 1; }));
  std::this_thread::sleep_for(kRestSeconds * 2s);
  EXPECT_EQ(one->refusal_count(), 1U) << "it was tried again and again";
  EXPECT_EQ(one->pictures().back().picture.pixels.front(), 1);
  device->refuse_scenes = false;
  one->turn(6);
  runner.wake();
  ASSERT_TRUE(eventually([&] { return one->pictures().back().picture.pixels.front() == 6; }));
  EXPECT_GT(one->began_epoch, epoch);
  EXPECT_EQ(one->failure_count(), 0U);
}

TEST_F(RunnerTest, FallsBackToSmallerSizeOnOutOfMemory) {
  device->seconds_per_megapixel = 8;
  const auto one = viewer({200, 200});
  ASSERT_TRUE(eventually([&] { return !one->pictures().empty(); }));
  device->refuse_wider_than = 150;
  one->turn(2);
  runner.wake();
  ASSERT_TRUE(eventually([&] { return one->refusal_count() == 1; }));
  const std::uint64_t epoch = one->began_epoch;
  std::this_thread::sleep_for(400ms);
  EXPECT_EQ(one->refusal_count(), 1U);
  EXPECT_EQ(one->began_epoch, epoch);
  EXPECT_GE(one->pictures().back().info.samples, 2U) << "it continues to converge";
  EXPECT_EQ(one->failure_count(), 0U);
}

TEST_F(RunnerTest, ReturningViewerGetsTheCurrentImage) {
  const auto one = viewer();
  ASSERT_TRUE(eventually([&] {
    const auto pictures = one->pictures();
    return !pictures.empty() && pictures.back().info.converged && !pictures.back().info.moving;
  }));
  const auto before = one->pictures();
  one->again();
  runner.wake();
  ASSERT_TRUE(eventually([&] { return one->pictures().size() == before.size() + 1; }));
  EXPECT_EQ(one->pictures().back().info.samples, before.back().info.samples);
  EXPECT_EQ(one->pictures().back().info.epoch, before.back().info.epoch);
}

struct TogetherTest : testing::Test {
  std::shared_ptr<FakeDevice> device = std::make_shared<FakeDevice>();
  SystemClock clock;

  /// Returns how many renderers worked at once while four sessions converged.
  int at_once(double device_parallel, bool queues) {
    device->seconds_per_megapixel = 0.5;  // 5 ms per sample of 100 x 100 pixels
    Runner::Options options;
    options.rules = {.target_error = 0.1, .fewest_samples = 4, .device_parallel = device_parallel};
    options.device_queues = queues;
    Runner runner(std::make_unique<MarginalGain>(), clock, options);
    std::vector<std::shared_ptr<TestClient>> viewers;
    for (int i = 0; i < 4; ++i) {
      viewers.push_back(std::make_shared<TestClient>(clock));
      runner.add(viewers.back(), std::make_unique<FakeRenderer>(device, nullptr), 0);
    }
    EXPECT_TRUE(eventually([&] {
      return std::all_of(viewers.begin(), viewers.end(),
                         [](const auto& viewer) { return viewer->samples >= 10; });
    }));
    runner.stop();
    const RunnerTimes times = runner.times();
    EXPECT_GT(times.quanta, 4U);
    EXPECT_GT(times.rendering, 0.08);
    EXPECT_GT(times.busy, 0.02);
    return device->most_at_once;
  }
};

TEST_F(TogetherTest, SmallQuantaRunConcurrently) { EXPECT_EQ(at_once(1e6, false), 4); }

TEST_F(TogetherTest, QueuesOneMoreBehindAFullDevice) { EXPECT_EQ(at_once(1e3, true), 2); }

TEST_F(TogetherTest, FullDeviceWithoutAQueueRunsOne) { EXPECT_EQ(at_once(1e3, false), 1); }

/// Two sessions share a full device all the time. Each must be charged only its own cost.
TEST_F(TogetherTest, SessionsAreNotChargedForWaiting) {
  device->seconds_per_megapixel = 0.5;
  device->one_at_a_time = true;
  Runner::Options options;
  options.rules = {.target_error = 1e-6, .device_parallel = 1e3};
  options.device_queues = true;
  Runner runner(std::make_unique<RoundRobin>(), clock, options);
  std::vector<std::shared_ptr<TestClient>> viewers;
  for (int i = 0; i < 2; ++i) {
    viewers.push_back(std::make_shared<TestClient>(clock));
    runner.add(viewers.back(), std::make_unique<FakeRenderer>(device, nullptr), 0);
  }
  EXPECT_TRUE(eventually([&] { return viewers[0]->samples + viewers[1]->samples >= 60; }));
  runner.stop();
  const RunnerTimes times = runner.times();
  // Two quanta are in flight, one of which waits, so the lanes are busy for twice as long as the
  // device.
  EXPECT_GT(times.rendering, 1.5 * times.busy);
  EXPECT_EQ(device->most_at_once, 2);
  // The time reported to both and charged to their accounts is the time that the device worked.
  const double charged = viewers[0]->charged() + viewers[1]->charged();
  EXPECT_LE(charged, times.busy * 1.001);
  EXPECT_GT(charged, 0.5 * times.busy);
}

StillJob still_job(const std::shared_ptr<FakeDevice>& device, std::promise<double>& done) {
  StillJob job;
  job.scene = std::make_shared<const v1::Scene>();
  job.canvas = {64, 64};
  job.samples = 10;
  job.renderer = std::make_unique<FakeRenderer>(device, nullptr);
  job.cancelled = [] { return false; };
  job.done = [&done](Result<PictureRgb8> picture, double error) {
    done.set_value(picture && picture->size == Canvas{64, 64} ? error : -1);
  };
  return job;
}

TEST_F(RunnerTest, RendersAStillDuringADrag) {
  device->seconds_per_megapixel = 0.1;
  const auto one = viewer();
  std::promise<double> done;
  auto finished = done.get_future();
  runner.submit(still_job(device, done));
  while (finished.wait_for(10ms) != std::future_status::ready) {
    one->turn(1);
    runner.wake();
  }
  EXPECT_NEAR(finished.get(), 0.5 / std::sqrt(10.0), 1e-9);
}

TEST_F(RunnerTest, StillIsDeliveredAtItsDeadline) {
  std::promise<double> done;
  auto finished = done.get_future();
  StillJob job = still_job(device, done);
  job.samples = 1u << 30;
  job.until = {};
  runner.submit(std::move(job));
  ASSERT_EQ(finished.wait_for(60s), std::future_status::ready);
  EXPECT_GT(finished.get(), 0.5 / std::sqrt(double(1u << 30)));
}

TEST_F(RunnerTest, StillIsDeliveredAtItsTargetError) {
  std::promise<double> done;
  auto finished = done.get_future();
  StillJob job = still_job(device, done);
  job.samples = 1u << 30;
  job.error = 0.1;
  runner.submit(std::move(job));
  ASSERT_EQ(finished.wait_for(60s), std::future_status::ready);
  EXPECT_LE(finished.get(), 0.1);
}

TEST_F(RunnerTest, LaterStillsOvertakeABackgroundStill) {
  device->seconds_per_megapixel = 1;  // 4 ms per sample of 64 x 64 pixels
  std::promise<double> later, sooner;
  auto ended_later = later.get_future(), ended_sooner = sooner.get_future();
  StillJob background = still_job(device, later);
  background.rank = StillRank::kBackground;
  background.samples = 1000;
  runner.submit(std::move(background));
  ASSERT_TRUE(eventually([&] { return device->samples > 0; })) << "it is under way";
  runner.submit(still_job(device, sooner));
  ASSERT_EQ(ended_sooner.wait_for(60s), std::future_status::ready);
  EXPECT_EQ(ended_later.wait_for(0s), std::future_status::timeout);
  device->seconds_per_megapixel = 0;
  ASSERT_EQ(ended_later.wait_for(60s), std::future_status::ready) << "and continues where it was";
  EXPECT_NEAR(ended_later.get(), 0.5 / std::sqrt(1000.0), 1e-9);
}

TEST_F(RunnerTest, DropsACancelledStill) {
  std::promise<double> done;
  StillJob job = still_job(device, done);
  std::atomic<bool> asked{false};
  job.cancelled = [&] {
    asked = true;
    return true;
  };
  runner.submit(std::move(job));
  EXPECT_TRUE(eventually([&] { return asked.load(); }));
  EXPECT_EQ(done.get_future().wait_for(50ms), std::future_status::timeout);
}

TEST_F(RunnerTest, RemovingASessionInterruptsItsQuantum) {
  const auto one = viewer({200, 200});
  ASSERT_TRUE(eventually([&] { return one->samples > 0; }));
  device->seconds_per_megapixel = 1000;
  one->turn(2);
  runner.wake();
  std::this_thread::sleep_for(30ms);
  runner.remove(handle);
  // A quantum takes the speed of its start. The second session must not begin one at this speed.
  device->seconds_per_megapixel = 0;
  const auto two = viewer();
  EXPECT_TRUE(eventually([&] { return !two->pictures().empty(); }));
  ASSERT_TRUE(eventually([&] { return one.use_count() == 1; })) << "the runner still holds it";
}

TEST_F(RunnerTest, ReportsALostDevice) {
  const auto one = viewer();
  device->lost = true;
  one->turn(3);
  runner.wake();
  EXPECT_TRUE(eventually([&] { return lost == 1; }));
  EXPECT_EQ(one->failure_count(), 1U);
}

/// The labels of pictures are correct: the first ones are denoised and say so, the last never is.
TEST_F(RunnerTest, LabelsDenoisedImagesAndEndsWithARawOne) {
  auto viewing = viewer();
  ASSERT_TRUE(eventually([&] {
    const auto pictures = viewing->pictures();
    return !pictures.empty() && pictures.back().info.converged;
  }));
  const auto pictures = viewing->pictures();
  EXPECT_TRUE(pictures.front().info.denoised);
  for (const RenderedPicture& picture : pictures) {
    EXPECT_EQ(picture.info.denoised, !picture.info.converged) << picture.info.samples;
  }
}

}  // namespace
}  // namespace diaphane::render
