#include "renderd/schedule/ledger.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "renderd/schedule/canvas.h"

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;

struct LedgerTest : testing::Test {
  Ledger::Time now{100s};
  LedgerRules rules{.target_error = 0.01, .fewest_samples = 16, .device_parallel = 40'000};
  DeviceCosts device;
  Ledger ledger{7};
  ViewRequest requested;

  LedgerTest() {
    requested.version = 1;
    requested.scene = std::make_shared<const v1::Scene>();
    requested.viewport = {100, 100};
    refresh();
  }
  void refresh() { ledger.refresh(requested, device, rules, now); }
  void input() {
    ++requested.version;
    requested.last_input = now;
  }
  SessionView view() const { return ledger.view(1, device, rules, now); }
  void render(std::uint32_t samples, double error) {
    if (ledger.stale()) ledger.began(0.002, now);
    Progress progress = ledger.progress();
    progress.samples += samples;
    progress.error = error;
    now += 10ms;
    ledger.rendered({samples, 0.01, 0}, progress, device, now);
  }
};

TEST_F(LedgerTest, NewSessionWaitsForItsFirstFrame) {
  now += 3ms;
  refresh();
  EXPECT_EQ(view().samples, 0U);
  EXPECT_TRUE(std::isinf(view().error));
  EXPECT_NEAR(view().seconds_unanswered, 0.003, 1e-9);
  EXPECT_NEAR(view().seconds_waiting, 0.003, 1e-9);
}

TEST_F(LedgerTest, NewSessionStartsFromTheMeasuredDeviceCosts) {
  render(10, 0.1);
  EXPECT_NEAR(view().seconds_per_sample, 0.001, 1e-12);
  ledger.shown(0.003, device, now);
  EXPECT_NEAR(view().seconds_first, 0.005, 1e-12) << "scene and picture";
  EXPECT_NEAR(view().fill, 0.25, 1e-12);
  Ledger other(0);
  other.refresh(requested, device, rules, now);
  EXPECT_NEAR(other.view(2, device, rules, now).seconds_per_sample, 0.001, 1e-12);
  EXPECT_NEAR(other.view(2, device, rules, now).seconds_first, 0.005, 1e-12);
}

TEST_F(LedgerTest, SizesMovingImagesByTheCostOfADraft) {
  render(2, 0.3);
  const double draft = view().seconds_per_sample;
  Progress progress = ledger.progress();
  progress.samples += 1;
  ledger.rendered({.samples = 1, .seconds = 1.0, .refined = true}, progress, device, now);
  EXPECT_NEAR(view().seconds_per_sample, 1.0, 1e-12) << "another sample of the better estimator";
  EXPECT_NEAR(device.seconds_per_pixel * 1e4, draft, 1e-12);
  input();
  refresh();
  EXPECT_NEAR(view().seconds_per_sample, draft, 1e-12) << "the next picture begins with a draft";
}

TEST_F(LedgerTest, CountsWhatItsFirstImagesTookLately) {
  EXPECT_EQ(view().seconds_lately, 0);
  render(10, 0.1);
  ledger.shown(0.003, device, now);
  const double shown = 0.002 * std::exp(-0.01) + 0.01 + 0.003;  // scene, 10 ms earlier; samples
  EXPECT_NEAR(view().seconds_lately, shown, 1e-12);
  render(10, 0.08);
  EXPECT_NEAR(view().seconds_lately, shown * std::exp(-0.01), 1e-12) << "refinement does not count";
  now += 1s;
  EXPECT_NEAR(view().seconds_lately, shown * std::exp(-1.01), 1e-12);
}

TEST_F(LedgerTest, OnlyItsOwnImageAnswersAnInput) {
  render(1, 0.5);
  input();
  now += 5ms;
  refresh();
  ledger.shown(0, device, now);  // a picture of the previous scene
  EXPECT_GT(view().seconds_unanswered, 0);
  render(1, 0.5);
  refresh();
  ledger.shown(0, device, now);
  EXPECT_EQ(view().seconds_unanswered, 0);
}

TEST_F(LedgerTest, UnansweredTimeCountsFromTheOldestInput) {
  render(1, 0.5);
  ledger.shown(0, device, now);
  input();
  now += 10ms;
  refresh();
  input();
  now += 10ms;
  refresh();
  EXPECT_NEAR(view().seconds_unanswered, 0.02, 1e-9);
}

TEST_F(LedgerTest, DoesNotConvergeWithFewSamples) {
  render(15, 0.001);
  EXPECT_FALSE(ledger.converged(rules));
  EXPECT_TRUE(gains(view()));
  render(1, 0.001);
  EXPECT_TRUE(ledger.converged(rules));
  EXPECT_FALSE(gains(view()));
}

TEST_F(LedgerTest, ViewerMayStopEarlierButNotLater) {
  render(20, 0.1);
  refresh();
  EXPECT_FALSE(ledger.converged(rules));
  requested.effort.stop_error = 0.2;
  refresh();
  EXPECT_TRUE(ledger.converged(rules));
  EXPECT_EQ(view().error, 0) << "nothing more to gain";
  requested.effort = {.stop_samples = 20};
  refresh();
  EXPECT_TRUE(ledger.converged(rules));
  requested.effort = {.stop_samples = 21};
  refresh();
  EXPECT_FALSE(ledger.converged(rules));
  EXPECT_GT(view().error, view().target_error);

  render(20, 0.009);
  requested.effort = {.stop_error = 0.001, .stop_samples = 1'000};
  refresh();
  EXPECT_TRUE(ledger.converged(rules)) << "the worker's limit applies";
}

TEST_F(LedgerTest, ViewerLimitsTheMovingSize) {
  const auto moving = [&](double viewer, double connection) {
    requested.effort.moving_scale = viewer;
    requested.moving_scale = connection;
    input();
    refresh();
    return ledger.planned();
  };
  EXPECT_EQ(moving(1, 1), (Canvas{100, 100}));
  EXPECT_EQ(moving(0.5, 1), (Canvas{50, 50}));
  EXPECT_EQ(moving(0.5, 0.25).width, 26U) << "the connection also limits the size";
  now += 1s;
  refresh();
  EXPECT_EQ(ledger.planned(), (Canvas{100, 100})) << "at rest it has full size";
}

TEST_F(LedgerTest, SessionWithoutGainDoesNotWait) {
  render(20, 0.001);
  now += 5s;
  refresh();
  EXPECT_EQ(view().seconds_waiting, 0);
  input();
  now += 1s;
  refresh();
  EXPECT_NEAR(view().seconds_waiting, 1, 1e-9);
  requested.visible = false;
  refresh();
  EXPECT_EQ(view().seconds_waiting, 0);
}

TEST_F(LedgerTest, DoesNotRetryARefusedScene) {
  render(1, 0.5);
  input();
  refresh();
  ASSERT_TRUE(ledger.stale());
  ledger.refused();
  refresh();
  EXPECT_FALSE(ledger.stale());
  EXPECT_EQ(view().seconds_unanswered, 0);
  input();
  refresh();
  EXPECT_TRUE(ledger.stale());
}

TEST_F(LedgerTest, EpochIncreasesWithEachScene) {
  render(1, 0.5);
  EXPECT_EQ(ledger.epoch(), 8U);
  input();
  refresh();
  render(1, 0.5);
  EXPECT_EQ(ledger.epoch(), 9U);
}

/// When the pointer is lifted, the full size is rendered at once, without waiting for silence.
TEST_F(LedgerTest, EndOfAGestureCountsAsRestImmediately) {
  input();
  refresh();
  EXPECT_TRUE(ledger.moving());
  EXPECT_LT(view().seconds_since_input, kRestSeconds);
  requested.rest = true;
  input();
  refresh();
  EXPECT_FALSE(ledger.moving());
  EXPECT_GE(view().seconds_since_input, kRestSeconds);
  render(2, 0.1);
  EXPECT_GE(ledger.emission(rules, now)->seconds_since_input, kRestSeconds);
  EXPECT_FALSE(ledger.emission(rules, now)->moving);
}

/// A full picture of a second follows, so that the viewer sees at once that the input arrived.
TEST_F(LedgerTest, ShowsAPreviewBeforeASlowImageAtRest) {
  device.seconds_per_pixel = 1e-4;  // 1 s for the viewport
  requested.rest = true;
  input();
  refresh();
  EXPECT_TRUE(ledger.moving());
  EXPECT_LT(ledger.planned().pixels() * device.seconds_per_pixel, 0.1);
  EXPECT_LT(view().seconds_since_input, kRestSeconds) << "it is urgent";
  const Canvas small = ledger.planned();
  ledger.began(0, now);
  ledger.rendered({1, 1e-4 * small.pixels(), 0}, {1, 0.1, 1}, device, now);
  refresh();
  EXPECT_EQ(ledger.planned(), small) << "it is not replaced before it is shown";
  EXPECT_TRUE(ledger.emission(rules, now)->moving);
  ledger.shown(0, device, now);
  refresh();
  EXPECT_FALSE(ledger.moving());
  EXPECT_TRUE(ledger.stale());
  EXPECT_EQ(ledger.planned(), requested.viewport);
  ledger.began(0, now);
  ledger.rendered({1, 1, 0}, {1, 1, 1}, device, now);
  refresh();
  EXPECT_FALSE(ledger.stale()) << "one preview is enough";
}

TEST_F(LedgerTest, FastOrAssistedImageHasNoPreview) {
  requested.rest = true;
  const auto previews = [&](double seconds_per_pixel) {
    device.seconds_per_pixel = seconds_per_pixel;
    input();
    refresh();
    return ledger.moving();
  };
  EXPECT_FALSE(previews(1e-5)) << "0.1 s";
  EXPECT_TRUE(previews(1e-4));
  requested.viewport = {1000, 1000};
  EXPECT_TRUE(previews(0)) << "the speed of the device is unknown";
  requested.full_size = true;
  EXPECT_FALSE(previews(0));
  EXPECT_FALSE(previews(1e-4));
}

TEST_F(LedgerTest, SampleNoiseFollowsTheLastKnownError) {
  EXPECT_EQ(view().noise, 0);
  render(4, 0.1);
  EXPECT_NEAR(view().noise, 0.2, 1e-12);
  input();
  refresh();
  render(1, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(view().noise, 0.2, 1e-12) << "one sample has no error estimate";
}

}  // namespace
}  // namespace diaphane::render
