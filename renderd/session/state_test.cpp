#include "renderd/session/state.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/support/renderd/test_messages.h"

namespace diaphane::render {
namespace {

using std::chrono::milliseconds;

struct StateTest : testing::Test {
  StateTest() {
    state.requested.scene = std::make_shared<const v1::Scene>(plain_scene());
    state.requested.viewport = {512, 512};
    state.requested.version = 1;
    connect();
  }
  void connect() { me = attach(state, owner(), now)->connection; }
  Outcome say(const v1::ClientMessage& message) { return receive(state, me, message, now); }
  Admission admit(const FrameInfo& info) {
    return render::admit(state, v1::JPEG, info, now).admission;
  }
  // Returns what is sent to the only viewer, if anything.
  std::optional<OutgoingFrame> depart(const FrameInfo& info) {
    outgoing_frames = render::depart(state, v1::JPEG, info, {true, 1000}, now);
    if (outgoing_frames.frames.empty()) return std::nullopt;
    return outgoing_frames.frames.front();
  }
  Receiver& viewer() { return *state.audience.find(me); }

  SessionState state;
  std::uint64_t me = 0;
  OutgoingFrames outgoing_frames;
  TimePoint now = TimePoint{} + std::chrono::hours(1);
};

TEST_F(StateTest, RefusesMessagesBeforeTheGreeting) {
  for (const v1::ClientMessage& message : {turned(1), ack(1), v1::ClientMessage{}}) {
    const Outcome outcome = say(message);
    ASSERT_TRUE(outcome.problem);
    EXPECT_TRUE(outcome.problem->fatal());
    EXPECT_EQ(state.requested.version, 1U);
  }
  EXPECT_TRUE(say(hello()).configure);
  EXPECT_EQ(state.requested.viewport, (Canvas{640, 480}));
}

TEST_F(StateTest, GreetingWithUnknownProtocolOrCodecIsFatal) {
  v1::ClientMessage newer = hello();
  newer.mutable_hello()->set_protocol(2);
  EXPECT_TRUE(say(newer).problem->fatal());
  v1::ClientMessage blind = hello();
  blind.mutable_hello()->clear_codecs();
  EXPECT_EQ(say(blind).problem->code(), "unsupported");
  EXPECT_FALSE(viewer().greeted);
}

TEST_F(StateTest, NewestSceneWinsAndDuplicatesAreIgnored) {
  say(hello());
  for (const std::uint64_t seq : {1, 2, 3, 7}) EXPECT_TRUE(say(turned(seq)).wake);
  const std::uint64_t version = state.requested.version;
  EXPECT_FALSE(say(turned(3)).wake);
  EXPECT_FALSE(say(turned(7)).wake);
  EXPECT_EQ(state.requested.scene->camera().eye().x(), 7);
  EXPECT_EQ(state.requested.version, version);
  EXPECT_EQ(state.requested.input_seq, 7U);
}

TEST_F(StateTest, ReloadedPageMayRestartItsSequenceNumbers) {
  say(hello());
  say(turned(100));
  connect();
  say(hello());
  EXPECT_TRUE(say(turned(1)).wake);
  EXPECT_EQ(state.requested.scene->camera().eye().x(), 1);
}

TEST_F(StateTest, UnchangedSceneResendsTheImageWithoutRendering) {
  say(hello());
  say(turned(1));
  const std::uint64_t version = state.requested.version;
  state.requested.picture_again = false;
  v1::ClientMessage same = turned(1);
  same.mutable_scene()->set_input_seq(2);
  EXPECT_TRUE(say(same).wake);
  EXPECT_EQ(state.requested.version, version);
  EXPECT_TRUE(state.requested.picture_again);
  EXPECT_EQ(state.requested.input_seq, 2U);
}

TEST_F(StateTest, RefusesInvalidSceneAndNamesTheField) {
  say(hello());
  say(turned(1));
  const ViewRequest before = state.requested;
  for (const double wrong :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    v1::Scene scene = plain_scene();
    scene.mutable_camera()->mutable_eye()->set_y(wrong);
    const std::uint64_t seq = viewer().newest_input + 1;
    const Outcome outcome = say(update(seq, scene));
    ASSERT_TRUE(outcome.problem);
    EXPECT_FALSE(outcome.problem->fatal());
    EXPECT_EQ(outcome.problem->code(), "invalid");
    EXPECT_EQ(outcome.problem->field(), "camera.eye.y");
    EXPECT_EQ(outcome.problem->input_seq(), seq);
    EXPECT_FALSE(outcome.wake);
    EXPECT_EQ(state.requested.version, before.version);
    EXPECT_EQ(state.requested.scene, before.scene);
    EXPECT_EQ(state.requested.input_seq, before.input_seq);
  }
  EXPECT_TRUE(say(turned(50)).wake);
}

TEST(VisitorCanvas, KeepsTheAspectRatioWithinTheSizeLimit) {
  EXPECT_EQ(visitor_canvas({1920, 1080}), (Canvas{1920, 1080}));
  EXPECT_EQ(visitor_canvas({2560, 1440}), (Canvas{2560, 1440}));
  EXPECT_EQ(visitor_canvas({4096, 4096}), (Canvas{1920, 1920}));
  const Canvas wide = visitor_canvas({4096, 1024});
  EXPECT_LE(double(wide.width) * wide.height, kMostVisitorPixels);
  EXPECT_NEAR(double(wide.width) / wide.height, 4, 0.01);
}

TEST_F(StateTest, RefusesViewportOutOfRangeCompletely) {
  say(hello());
  const Canvas before = state.requested.viewport;
  struct Case {
    std::uint32_t width, height;
    const char* field;
    const char* code;
  };
  std::uint64_t seq = 0;
  for (const Case& wrong :
       {Case{4097, 100, "viewport.width", "too_large"},
        Case{100, 0xffffffff, "viewport.height", "too_large"},
        Case{0, 0, "viewport.width", "invalid"}, Case{100, 15, "viewport.height", "invalid"}}) {
    v1::ClientMessage message = turned(++seq);
    message.mutable_scene()->mutable_viewport()->set_width(wrong.width);
    message.mutable_scene()->mutable_viewport()->set_height(wrong.height);
    const Outcome outcome = say(message);
    ASSERT_TRUE(outcome.problem);
    EXPECT_EQ(outcome.problem->field(), wrong.field);
    EXPECT_EQ(outcome.problem->code(), wrong.code);
    EXPECT_EQ(state.requested.viewport, before);
    EXPECT_EQ(state.requested.scene->camera().eye().x(), 0) << "the update was applied partially";
  }
}

TEST_F(StateTest, RevertsToTheShownSceneOnRefusal) {
  say(hello());
  say(turned(1));
  began(state, 1, state.requested);
  say(turned(2));
  const ViewRequest refused_one = state.requested;
  const Outcome outcome = refused(state, refused_one, {ErrorCode::kOutOfMemory, "No memory.", ""});
  EXPECT_EQ(outcome.problem->input_seq(), 2U);
  EXPECT_FALSE(outcome.problem->fatal());
  EXPECT_EQ(state.requested.scene->camera().eye().x(), 1);
  // But not if something newer was requested meanwhile.
  say(turned(3));
  const ViewRequest old = state.requested;
  say(turned(4));
  refused(state, old, {ErrorCode::kOutOfMemory, "No memory.", ""});
  EXPECT_EQ(state.requested.scene->camera().eye().x(), 4);
}

TEST_F(StateTest, LimitsFramesInFlightToTwo) {
  say(hello());
  began(state, 1, state.requested);
  ASSERT_EQ(admit(frame(1)), Admission::kGo);
  EXPECT_EQ(depart(frame(1))->seq, 1U);
  ASSERT_EQ(admit(frame(1, false)), Admission::kGo);
  ASSERT_EQ(admit(frame(1, false)), Admission::kWait) << "one is being encoded";
  EXPECT_EQ(depart(frame(1, false))->seq, 2U);
  EXPECT_EQ(admit(frame(1, false)), Admission::kWait);
  EXPECT_FALSE(say(ack(3)).room) << "it was never sent";
  EXPECT_TRUE(say(ack(1)).room);
  EXPECT_EQ(admit(frame(1, false)), Admission::kGo);
}

// No ghosting: a property over random orders of all events.
TEST_F(StateTest, NeverSendsOutdatedFrames) {
  say(hello());
  std::mt19937 random(3);
  std::uint64_t epoch = 0;
  std::uint64_t seq = 0;
  std::uint64_t newest_sent = 0;
  std::vector<FrameInfo> encoding;
  int sent = 0;
  for (int i = 0; i < 20000; ++i) {
    switch (random() % 4) {
      case 0:
        began(state, ++epoch, state.requested);
        break;
      case 1: {
        const std::uint64_t of = epoch > 3 ? epoch - random() % 3 : epoch;
        const FrameInfo info = frame(of, random() % 2 == 0);
        if (admit(info) == Admission::kGo) encoding.push_back(info);
        break;
      }
      case 2:
        if (!encoding.empty()) {
          const FrameInfo info = encoding.front();
          encoding.erase(encoding.begin());
          const auto outgoing = depart(info);
          if (!outgoing) break;
          ASSERT_GE(info.epoch, newest_sent);
          ASSERT_TRUE(info.epoch == state.epoch || info.first_of_epoch);
          newest_sent = info.epoch;
          seq = outgoing->seq;
          ++sent;
        }
        break;
      default:
        say(ack(seq));
    }
  }
  EXPECT_GT(sent, 1000);
}

TEST_F(StateTest, SendsFramesDuringADragFasterThanTheDevice) {
  say(hello());
  int sent = 0;
  for (std::uint64_t epoch = 1; epoch <= 50; ++epoch) {
    began(state, epoch, state.requested);
    // The next input is handled before this epoch's picture is encoded.
    began(state, epoch + 1, state.requested);
    if (admit(frame(epoch)) != Admission::kGo) continue;
    const auto outgoing = depart(frame(epoch));
    ASSERT_TRUE(outgoing);
    say(ack(outgoing->seq));
    ++sent;
  }
  EXPECT_EQ(sent, 50);
}

TEST_F(StateTest, ReportsConvergenceOncePerEpoch) {
  say(hello());
  began(state, 1, state.requested);
  FrameInfo last = frame(1);
  admit(last);
  EXPECT_FALSE(depart(last)->state);
  last.converged = true;
  admit(last);
  const OutgoingFrame converged = *depart(last);
  ASSERT_TRUE(converged.state);
  EXPECT_TRUE(converged.state->converged());
  say(ack(2));
  began(state, 2, state.requested);
  admit(frame(2));
  const OutgoingFrame again = *depart(frame(2));
  ASSERT_TRUE(again.state);
  EXPECT_FALSE(again.state->converged());
  EXPECT_EQ(again.state->epoch(), 2U);
}

TEST_F(StateTest, MeasuresLatencyFromTheOldestUnansweredInput) {
  say(hello());
  say(turned(1));
  now += milliseconds(10);
  say(turned(2));
  began(state, 1, state.requested);
  now += milliseconds(10);
  admit(frame(1, true, 2));
  ASSERT_TRUE(depart(frame(1, true, 2)));
  ASSERT_TRUE(outgoing_frames.input_to_frame);
  EXPECT_NEAR(*outgoing_frames.input_to_frame, 0.020, 1e-9);
  admit(frame(1, false, 2));
  ASSERT_TRUE(depart(frame(1, false, 2)));
  EXPECT_FALSE(outgoing_frames.input_to_frame);
}

TEST_F(StateTest, HiddenDetachedAndStalledViewersDoNotWatch) {
  EXPECT_FALSE(watched(state, now)) << "not greeted";
  say(hello());
  EXPECT_TRUE(watched(state, now));
  v1::ClientMessage message;
  message.mutable_visibility()->set_visible(false);
  say(message);
  EXPECT_FALSE(watched(state, now));
  message.mutable_visibility()->set_visible(true);
  state.requested.picture_again = false;
  say(message);
  EXPECT_TRUE(watched(state, now));
  EXPECT_TRUE(state.requested.picture_again);

  began(state, 1, state.requested);
  admit(frame(1));
  depart(frame(1));
  now += kStalledAfter + milliseconds(1);
  EXPECT_FALSE(watched(state, now));
  say(ack(1));
  EXPECT_TRUE(watched(state, now));
  detach(state, me, now);
  EXPECT_FALSE(watched(state, now));
  EXPECT_EQ(admit(frame(1)), Admission::kDrop);
}

TEST_F(StateTest, AttachedViewerGetsTheCurrentFrame) {
  say(hello());
  began(state, 5, state.requested);
  admit(frame(5));
  depart(frame(5));
  detach(state, me, now);
  state.requested.picture_again = false;
  connect();
  EXPECT_EQ(admit(frame(5, false)), Admission::kDrop) << "not greeted yet";
  EXPECT_TRUE(say(hello()).configure);
  EXPECT_TRUE(state.requested.picture_again);
  ASSERT_EQ(admit(frame(5, false)), Admission::kGo);
  EXPECT_EQ(depart(frame(5, false))->seq, 1U);
}

TEST_F(StateTest, GestureEndsOnlyWithItsLastInput) {
  say(hello());
  say(turned(1));
  EXPECT_FALSE(state.requested.rest);
  v1::ClientMessage last = turned(2);
  last.mutable_scene()->set_rest(true);
  say(last);
  EXPECT_TRUE(state.requested.rest);
  say(turned(3));
  EXPECT_FALSE(state.requested.rest);
}

TEST_F(StateTest, AnswersDepthQueriesAtALimitedRate) {
  say(hello());
  v1::ClientMessage query;
  query.mutable_depth_query()->set_id(7);
  query.mutable_depth_query()->set_x(1);
  query.mutable_depth_query()->set_y(0.25);
  const Outcome outcome = say(query);
  ASSERT_TRUE(outcome.depth);
  EXPECT_EQ(outcome.depth->id(), 7U);
  EXPECT_FALSE(outcome.wake) << "nothing is rendered again";
  EXPECT_EQ(say(query).problem->code(), "too_many");
  now += kDepthEvery;
  for (const double wrong : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    query.mutable_depth_query()->set_y(wrong);
    const Outcome refused = say(query);
    EXPECT_FALSE(refused.depth);
    EXPECT_EQ(refused.problem->code(), "invalid");
    EXPECT_FALSE(refused.problem->fatal());
  }
  query.mutable_depth_query()->set_y(0);
  EXPECT_TRUE(say(query).depth);
}

TEST_F(StateTest, AnswersKernelQueriesAtALimitedRate) {
  say(hello());
  v1::ClientMessage query;
  query.mutable_kernel();
  state.requested.picture_again = false;
  const Outcome outcome = say(query);
  EXPECT_FALSE(outcome.problem);
  EXPECT_TRUE(outcome.wake);
  EXPECT_TRUE(state.requested.kernel_report);
  EXPECT_TRUE(state.requested.picture_again) << "even for a converged image";
  const Outcome too_soon = say(query);
  ASSERT_TRUE(too_soon.problem);
  EXPECT_FALSE(too_soon.problem->fatal());
  now += kKernelEvery;
  EXPECT_FALSE(say(query).problem);
}

TEST_F(StateTest, AnswersGoodViewsQueriesOfThePresenterAtALimitedRate) {
  say(hello());
  v1::ClientMessage query;
  query.mutable_good_views();
  EXPECT_TRUE(say(query).good_views);
  const Outcome too_soon = say(query);
  EXPECT_FALSE(too_soon.good_views);
  ASSERT_TRUE(too_soon.problem);
  EXPECT_EQ(too_soon.problem->field(), "good_views");
  EXPECT_FALSE(too_soon.problem->fatal());
  now += kKernelEvery;
  EXPECT_TRUE(say(query).good_views);
}

/// Switching the denoiser off changes the picture, so it is a new version of the request.
TEST(SessionState, RequestsRawImagesOnlyOnDemand) {
  SessionState state;
  const TimePoint now{};
  const std::uint64_t me = attach(state, owner(), now)->connection;
  ASSERT_FALSE(receive(state, me, hello(), now).problem);
  ASSERT_FALSE(receive(state, me, turned(1), now).problem);
  EXPECT_FALSE(state.requested.raw);
  const std::uint64_t version = state.requested.version;
  v1::ClientMessage raw = turned(1);
  raw.mutable_scene()->set_input_seq(2);
  raw.mutable_scene()->set_raw(true);
  ASSERT_FALSE(receive(state, me, raw, now).problem);
  EXPECT_TRUE(state.requested.raw);
  EXPECT_EQ(state.requested.version, version + 1);
}

TEST(SessionState, AppliesLowerEffortAndRefusesInvalidValues) {
  SessionState state;
  const TimePoint now{};
  const std::uint64_t me = attach(state, owner(), now)->connection;
  ASSERT_FALSE(receive(state, me, hello(), now).problem);
  std::uint64_t seq = 0;
  const auto say = [&](double error, std::uint64_t samples, double scale) {
    v1::ClientMessage message = turned(1);
    message.mutable_scene()->set_input_seq(++seq);
    v1::Effort& effort = *message.mutable_scene()->mutable_effort();
    effort.set_stop_error(error);
    effort.set_stop_samples(samples);
    effort.set_moving_scale(scale);
    return receive(state, me, message, now).problem;
  };
  ASSERT_FALSE(say(0, 0, 0));
  EXPECT_EQ(state.requested.effort.moving_scale, 1);
  const std::uint64_t version = state.requested.version;
  ASSERT_FALSE(say(0, 0, 0.5));
  EXPECT_EQ(state.requested.version, version) << "the picture at rest is the same";
  EXPECT_EQ(state.requested.effort.moving_scale, 0.5);
  ASSERT_FALSE(say(0.25, 100, 0.5));
  EXPECT_EQ(state.requested.version, version + 1) << "the stopping point changed";
  EXPECT_EQ(state.requested.effort.stop_error, 0.25);
  EXPECT_EQ(state.requested.effort.stop_samples, 100U);

  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double error : {-0.1, 1.1, nan, inf, -inf}) {
    const auto problem = say(error, 0, 0);
    ASSERT_TRUE(problem) << error;
    EXPECT_EQ(problem->field(), "effort.stop_error");
    EXPECT_FALSE(problem->fatal());
  }
  for (const double scale : {-0.5, 0.01, 1.5, nan, inf}) {
    const auto problem = say(0, 0, scale);
    ASSERT_TRUE(problem) << scale;
    EXPECT_EQ(problem->field(), "effort.moving_scale");
  }
  EXPECT_EQ(state.requested.effort.stop_error, 0.25) << "a refused request changes nothing";

  // Without the limit, everything applies again.
  v1::ClientMessage message = turned(1);
  message.mutable_scene()->set_input_seq(++seq);
  ASSERT_FALSE(receive(state, me, message, now).problem);
  EXPECT_EQ(state.requested.effort.stop_error, 0);
  EXPECT_EQ(state.requested.effort.stop_samples, 0U);
}

}  // namespace
}  // namespace diaphane::render
