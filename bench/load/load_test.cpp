#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <set>

#include "bench/load/child.h"
#include "bench/load/hands.h"
#include "bench/load/latency.h"
#include "bench/load/load_run.h"
#include "bench/load/person.h"
#include "bench/load/recording.h"
#include "bench/load/scrape.h"
#include "bench/load/soak_plan.h"

namespace diaphane::api::load {
namespace {

using std::chrono::milliseconds;

TimePoint at(int ms) { return TimePoint{} + milliseconds(1'000'000 + ms); }

TEST(OpenInputs, MeasuresEachInputFromItsSendTimeToTheFrameThatShowsIt) {
  OpenInputs open;
  open.sent(1, at(0));
  open.sent(2, at(16));
  open.sent(3, at(33));
  const auto shown = open.shown(2, at(40), at(0));
  ASSERT_EQ(shown.seconds.size(), 2U);
  EXPECT_NEAR(shown.seconds[0], 0.040, 1e-9);
  EXPECT_NEAR(shown.seconds[1], 0.024, 1e-9);
  EXPECT_TRUE(open.shown(2, at(50), at(0)).seconds.empty());
  EXPECT_NEAR(open.shown(9, at(50), at(0)).seconds.at(0), 0.017, 1e-9);
}

TEST(OpenInputs, IgnoresWarmUpInputsAndCountsUnansweredInputsWithTheirAge) {
  OpenInputs open;
  open.sent(1, at(0));
  open.sent(2, at(100));
  open.sent(3, at(200));
  EXPECT_EQ(open.shown(2, at(110), at(50)).seconds.size(), 1U);
  EXPECT_NEAR(open.give_up(at(2200), at(50)).seconds.at(0), 2.0, 1e-9);
  EXPECT_TRUE(open.empty());
}

TEST(Percentile, ReturnsNearestRankOrZeroWithoutValues) {
  std::vector<double> values;
  for (int i = 100; i > 0; --i) values.push_back(i);
  EXPECT_EQ(percentile(values, 95), 95);
  EXPECT_EQ(percentile(values, 100), 100);
  std::vector<double> one{7}, none;
  EXPECT_EQ(percentile(one, 50), 7);
  EXPECT_EQ(percentile(none, 50), 0);
}

constexpr char kRecording[] = R"({"format": "diaphane-interaction", "version": 1,
  "viewport": {"width": 640, "height": 480}, "events": [
    {"at_ms": 0, "scene": {"bounces": 3, "camera": {"eye": {"x": 1}}}},
    {"at_ms": 20, "camera": {"eye": {"x": 2}}},
    {"at_ms": 2020, "camera": {"eye": {"x": 3}}},
    {"at_ms": 2020, "scene": {"bounces": 1, "camera": {"eye": {"x": 4}}}}]})";

TEST(Recording, ShowsTheScenesInTheirRhythm) {
  const auto recording = Recording::read(kRecording);
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->width, 640U);
  EXPECT_EQ(recording->height, 480U);
  ASSERT_EQ(recording->size(), 4U);
  const double eyes[] = {1, 2, 3, 4};
  const std::uint32_t bounces[] = {3, 3, 3, 1};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(recording->scene(i).camera().eye().x(), eyes[i]) << i;
    EXPECT_EQ(recording->scene(i).bounces(), bounces[i]) << i;
  }
  EXPECT_NEAR(recording->gap_after(0), 0.02, 1e-9);
  EXPECT_EQ(recording->gap_after(1), 0) << "a pause ends a gesture";
  EXPECT_GT(recording->gap_after(2), 0) << "inputs of the same millisecond follow each other";
  EXPECT_EQ(recording->gap_after(3), 0) << "the end of the recording";
}

TEST(Recording, RefusesWhatIsNone) {
  const std::string good = kRecording;
  const auto with = [&](const std::string& part, const std::string& other) {
    std::string text = good;
    return text.replace(text.find(part), part.size(), other);
  };
  for (const std::string& text :
       {std::string("no JSON"), std::string("[]"), with("diaphane-interaction", "film"),
        with("\"version\": 1", "\"version\": 2"), with("\"width\": 640", "\"width\": -1"),
        with("\"at_ms\": 2020", "\"at_ms\": 10"), with("\"at_ms\": 20", "\"at_ms\": \"x\""),
        with("\"scene\": {\"bounces\": 3", "\"camera\": {\"fog\": 3"),
        with("\"camera\": {\"eye\": {\"x\": 2}}", "\"none\": 1")}) {
    const auto read = Recording::read(text);
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().code, ErrorCode::kInvalid) << text;
  }
}

TEST(Hands, KeepsRequestedNumberOfDistinctSessionsMovingInRotation) {
  const auto trace = render::bench::make_trace("interactive", 20, 60, 3);
  Hands hands(trace, 5);
  std::vector<std::size_t> moving;
  std::set<std::size_t> ever;
  for (const auto& gesture : hands.begin()) moving.push_back(gesture.session);
  EXPECT_EQ(moving.size(), 5U);
  for (int i = 0; i < 200; ++i) {
    std::size_t& hand = moving[static_cast<std::size_t>(i * 7 % 5)];
    const auto next = hands.after(hand);
    EXPECT_GT(next.seconds, 0);
    hand = next.session;
    ever.insert(next.session);
    EXPECT_EQ(std::set<std::size_t>(moving.begin(), moving.end()).size(), 5U);
  }
  EXPECT_EQ(ever.size(), 20U);
}

TEST(Hands, ReplaysGesturesOfTraceInOrder) {
  const auto trace = render::bench::make_trace("interactive", 1, 60, 3);
  Hands hands(trace, 9);
  EXPECT_EQ(hands.moving(), 1U);
  const auto& gestures = trace.sessions[0].gestures;
  ASSERT_GE(gestures.size(), 2U);
  EXPECT_EQ(hands.begin().at(0).seconds, gestures[0].end - gestures[0].begin);
  EXPECT_EQ(hands.after(0).seconds, gestures[1].end - gestures[1].begin);
}

TEST(Turned, KeepsDistanceAndHeightAndReturnsAfterFullTurn) {
  v1::Scene scene;
  scene.mutable_camera()->mutable_eye()->set_x(3);
  scene.mutable_camera()->mutable_eye()->set_z(4);
  scene.mutable_camera()->mutable_target()->set_x(1);
  scene.mutable_camera()->mutable_up()->set_z(2);
  const v1::Scene quarter = turned(scene, 90);
  EXPECT_NEAR(quarter.camera().eye().x(), 1, 1e-12);
  EXPECT_NEAR(quarter.camera().eye().y(), 2, 1e-12);
  EXPECT_NEAR(quarter.camera().eye().z(), 4, 1e-12);
  EXPECT_NEAR(turned(quarter, 270).camera().eye().x(), 3, 1e-12);
}

// Returns the largest number that meets a limit, and how many runs the search took.
std::pair<std::size_t, int> searched(std::size_t first, std::size_t truth,
                                     std::size_t most = 4096) {
  Search search(first, most);
  int runs = 0;
  for (; search.next() != 0 && runs < 100; ++runs) search.tried(search.next() <= truth);
  return {search.largest_held(), runs};
}

TEST(Search, FindsLargestPassingValueWithinASixteenthFromAnyStart) {
  for (const std::size_t truth : {1U, 2U, 3U, 7U, 30U, 199U, 200U, 201U, 777U, 4000U}) {
    for (const std::size_t first : {1U, 2U, 16U, 200U}) {
      const auto [found, runs] = searched(first, truth);
      EXPECT_LE(found, truth);
      EXPECT_GE(double(found) + std::max(1.0, double(truth) / 15), double(truth)) << first;
      EXPECT_LE(runs, 18);
    }
  }
  EXPECT_EQ(searched(200, 0).first, 0U);
  EXPECT_EQ(searched(200, 9999, 512).first, 512U);
}

TEST(Metrics, ParsesSamplesWithLabelsAndSkipsMalformedLines) {
  const Samples samples = parse_metrics(
      "# HELP a b\na_total 3\nb{part=\"x y\",q=\"z\"} 1.5e3\nbroken\n\nc{le=\"+Inf\"} 7 123\n");
  EXPECT_EQ(value_of(samples, "a_total"), 3);
  EXPECT_EQ(value_of(samples, "b{part=\"x y\",q=\"z\"}"), 1500);
  EXPECT_EQ(value_of(samples, "c{le=\"+Inf\"}"), 7);
  EXPECT_EQ(value_of(samples, "nothing"), 0);
}

TEST(Child, StartsWithEnvironmentReportsCpuTimeAndStops) {
  char log[] = "/tmp/diaphane-child-XXXXXX";
  ::close(::mkstemp(log));
  auto child =
      Child::start("sh", {"-c", "echo $WORD; while :; do :; done"}, {{"WORD", "here"}}, log);
  ASSERT_TRUE(child);
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (processor_seconds(child->pid()) < 0.02 && std::chrono::steady_clock::now() < until) {
  }
  EXPECT_GE(processor_seconds(child->pid()), 0.02);
  EXPECT_TRUE(child->running());
  child->stop(std::chrono::seconds(5));
  EXPECT_FALSE(child->running());
  std::ifstream written(log);
  std::string word;
  written >> word;
  EXPECT_EQ(word, "here");
  ::unlink(log);
}

TEST(SoakPlan, DrawsEveryKindOfActAndSomeSlowReaders) {
  std::mt19937_64 draws(5);
  std::set<Act::Kind> kinds;
  int slow = 0, ended = 0;
  for (int i = 0; i < 200; ++i) {
    const Visit visit = draw_visit(draws, 0.1, 1);
    EXPECT_GE(visit.width, 16U);
    EXPECT_GE(visit.height, 16U);
    EXPECT_GE(visit.acts.size(), 2U);
    slow += visit.read_pause_ms > 0;
    ended += visit.ends_session;
    for (const Act& act : visit.acts) kinds.insert(act.kind);
  }
  EXPECT_EQ(kinds.size(), 6U);
  EXPECT_GT(slow, 10);
  EXPECT_GT(ended, 50);
  EXPECT_LT(ended, 150);
}

}  // namespace
}  // namespace diaphane::api::load
