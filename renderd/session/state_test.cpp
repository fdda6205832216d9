#include "renderd/session/state.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace diaphane::render {
namespace {

using std::chrono::milliseconds;

v1::Scene plain_scene() {
  v1::Scene scene;
  v1::Channel& channel = *scene.mutable_transfer_function()->add_channels();
  channel.set_name("bone");
  for (const double value : {100.0, 1000.0}) {
    v1::OpacityPoint& point = *channel.add_opacity();
    point.set_value(value);
    point.set_opacity(value / 1000);
  }
  channel.mutable_diffuse()->set_r(0.8);
  channel.mutable_diffuse()->set_g(0.8);
  channel.mutable_diffuse()->set_b(0.8);
  scene.mutable_transfer_function()->set_extinction_per_mm(1);
  v1::Rgb& sky = *scene.add_lights()->mutable_environment()->mutable_radiance();
  sky.set_r(1);
  sky.set_g(1);
  sky.set_b(1);
  scene.mutable_camera()->mutable_eye()->set_y(-500);
  scene.mutable_camera()->mutable_target();
  scene.mutable_camera()->mutable_up()->set_z(1);
  scene.mutable_camera()->set_vertical_fov_degrees(40);
  scene.mutable_phase();
  scene.mutable_display()->mutable_background();
  return scene;
}

v1::ClientMessage hello(std::uint32_t width = 640, std::uint32_t height = 480) {
  v1::ClientMessage message;
  v1::Hello& body = *message.mutable_hello();
  body.set_protocol(1);
  body.add_codecs(v1::JPEG);
  body.mutable_viewport()->set_width(width);
  body.mutable_viewport()->set_height(height);
  return message;
}

v1::ClientMessage update(std::uint64_t seq, const v1::Scene& scene) {
  v1::ClientMessage message;
  message.mutable_scene()->set_input_seq(seq);
  *message.mutable_scene()->mutable_scene() = scene;
  return message;
}

v1::ClientMessage turned(std::uint64_t seq) {
  v1::Scene scene = plain_scene();
  scene.mutable_camera()->mutable_eye()->set_x(static_cast<double>(seq));
  return update(seq, scene);
}

v1::ClientMessage ack(std::uint64_t seq) {
  v1::ClientMessage message;
  message.mutable_ack()->set_seq(seq);
  return message;
}

FrameInfo frame(std::uint64_t epoch, bool first = true, std::uint64_t input_seq = 0) {
  FrameInfo info;
  info.epoch = epoch;
  info.first_of_epoch = first;
  info.input_seq = input_seq;
  info.samples = first ? 1 : 2;
  return info;
}

struct StateTest : testing::Test {
  StateTest() {
    state.wanted.scene = std::make_shared<const v1::Scene>(plain_scene());
    state.wanted.viewport = {512, 512};
    state.wanted.version = 1;
    attach(state, now);
  }
  Outcome say(const v1::ClientMessage& message) { return receive(state, message, now); }

  SessionState state;
  TimePoint now = TimePoint{} + std::chrono::hours(1);
};

TEST_F(StateTest, NothingIsHeardBeforeAGreeting) {
  for (const v1::ClientMessage& message : {turned(1), ack(1), v1::ClientMessage{}}) {
    const Outcome outcome = say(message);
    ASSERT_TRUE(outcome.problem);
    EXPECT_TRUE(outcome.problem->fatal());
    EXPECT_EQ(state.wanted.version, 1U);
  }
  EXPECT_TRUE(say(hello()).configure);
  EXPECT_EQ(state.wanted.viewport, (Canvas{640, 480}));
}

TEST_F(StateTest, AGreetingOfAnotherProtocolOrWithoutAKnownCodecIsFatal) {
  v1::ClientMessage newer = hello();
  newer.mutable_hello()->set_protocol(2);
  EXPECT_TRUE(say(newer).problem->fatal());
  v1::ClientMessage blind = hello();
  blind.mutable_hello()->clear_codecs();
  EXPECT_EQ(say(blind).problem->code(), "unsupported");
  EXPECT_FALSE(state.greeted);
}

TEST_F(StateTest, TheNewestSceneWinsAndASecondCopyOfAnOldOneIsIgnored) {
  say(hello());
  for (const std::uint64_t seq : {1, 2, 3, 7}) EXPECT_TRUE(say(turned(seq)).wake);
  const std::uint64_t version = state.wanted.version;
  EXPECT_FALSE(say(turned(3)).wake);
  EXPECT_FALSE(say(turned(7)).wake);
  EXPECT_EQ(state.wanted.scene->camera().eye().x(), 7);
  EXPECT_EQ(state.wanted.version, version);
  EXPECT_EQ(state.wanted.input_seq, 7U);
}

TEST_F(StateTest, AReloadedPageMayCountFromOneAgain) {
  say(hello());
  say(turned(100));
  attach(state, now);
  say(hello());
  EXPECT_TRUE(say(turned(1)).wake);
  EXPECT_EQ(state.wanted.scene->camera().eye().x(), 1);
}

TEST_F(StateTest, AnInputThatChangesNothingAsksForAFrameButNotForANewPicture) {
  say(hello());
  say(turned(1));
  const std::uint64_t version = state.wanted.version;
  state.wanted.picture_again = false;
  v1::ClientMessage same = turned(1);
  same.mutable_scene()->set_input_seq(2);
  EXPECT_TRUE(say(same).wake);
  EXPECT_EQ(state.wanted.version, version);
  EXPECT_TRUE(state.wanted.picture_again);
  EXPECT_EQ(state.wanted.input_seq, 2U);
}

TEST_F(StateTest, ASceneThatIsRefusedNamesItsFieldAndThePictureStays) {
  say(hello());
  say(turned(1));
  const Wanted before = state.wanted;
  for (const double wrong :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    v1::Scene scene = plain_scene();
    scene.mutable_camera()->mutable_eye()->set_y(wrong);
    const std::uint64_t seq = state.newest_input + 1;
    const Outcome outcome = say(update(seq, scene));
    ASSERT_TRUE(outcome.problem);
    EXPECT_FALSE(outcome.problem->fatal());
    EXPECT_EQ(outcome.problem->code(), "invalid");
    EXPECT_EQ(outcome.problem->field(), "camera.eye.y");
    EXPECT_EQ(outcome.problem->input_seq(), seq);
    EXPECT_FALSE(outcome.wake);
    EXPECT_EQ(state.wanted.version, before.version);
    EXPECT_EQ(state.wanted.scene, before.scene);
    EXPECT_EQ(state.wanted.input_seq, before.input_seq);
  }
  EXPECT_TRUE(say(turned(50)).wake);
}

TEST_F(StateTest, AViewportOutOfBoundsIsRefusedWhole) {
  say(hello());
  const Canvas before = state.wanted.viewport;
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
    EXPECT_EQ(state.wanted.viewport, before);
    EXPECT_EQ(state.wanted.scene->camera().eye().x(), 0) << "half of an update was taken";
  }
}

TEST_F(StateTest, WhatTheRendererRefusesGoesBackToWhatIsShown) {
  say(hello());
  say(turned(1));
  began(state, 1, state.wanted);
  say(turned(2));
  const Wanted refused_one = state.wanted;
  const Outcome outcome = refused(state, refused_one, {ErrorCode::kOutOfMemory, "No memory.", ""});
  EXPECT_EQ(outcome.problem->input_seq(), 2U);
  EXPECT_FALSE(outcome.problem->fatal());
  EXPECT_EQ(state.wanted.scene->camera().eye().x(), 1);
  // But not when something newer was asked for meanwhile.
  say(turned(3));
  const Wanted old = state.wanted;
  say(turned(4));
  refused(state, old, {ErrorCode::kOutOfMemory, "No memory.", ""});
  EXPECT_EQ(state.wanted.scene->camera().eye().x(), 4);
}

TEST_F(StateTest, TwoFramesAreInFlightAndTheThirdWaitsForAnAcknowledgement) {
  say(hello());
  began(state, 1, state.wanted);
  ASSERT_EQ(admit(state, frame(1)), Admission::kGo);
  EXPECT_EQ(depart(state, frame(1), now).seq, 1U);
  ASSERT_EQ(admit(state, frame(1, false)), Admission::kGo);
  ASSERT_EQ(admit(state, frame(1, false)), Admission::kWait) << "one is being encoded";
  EXPECT_EQ(depart(state, frame(1, false), now).seq, 2U);
  EXPECT_EQ(admit(state, frame(1, false)), Admission::kWait);
  EXPECT_FALSE(say(ack(3)).room) << "it was never sent";
  EXPECT_TRUE(say(ack(1)).room);
  EXPECT_EQ(admit(state, frame(1, false)), Admission::kGo);
}

// The law that nothing ghosts, over random orders of everything that can happen.
TEST_F(StateTest, AnOlderEpochIsNeverSentAfterANewerNorARefinementOfThePast) {
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
        began(state, ++epoch, state.wanted);
        break;
      case 1: {
        const std::uint64_t of = epoch > 3 ? epoch - random() % 3 : epoch;
        const FrameInfo info = frame(of, random() % 2 == 0);
        if (admit(state, info) == Admission::kGo) encoding.push_back(info);
        break;
      }
      case 2:
        if (!encoding.empty()) {
          const FrameInfo info = encoding.front();
          encoding.erase(encoding.begin());
          if (!still_useful(state, info)) {
            state.flight.release();
            break;
          }
          ASSERT_GE(info.epoch, newest_sent);
          ASSERT_TRUE(info.epoch == state.epoch || info.first_of_epoch);
          newest_sent = info.epoch;
          seq = depart(state, info, now).seq;
          ++sent;
        }
        break;
      default:
        say(ack(seq));
    }
  }
  EXPECT_GT(sent, 1000);
}

TEST_F(StateTest, ADragFasterThanTheDeviceStillShowsPictures) {
  say(hello());
  int sent = 0;
  for (std::uint64_t epoch = 1; epoch <= 50; ++epoch) {
    began(state, epoch, state.wanted);
    // Before this epoch's picture is encoded the next input is taken up.
    began(state, epoch + 1, state.wanted);
    if (admit(state, frame(epoch)) != Admission::kGo) continue;
    ASSERT_TRUE(still_useful(state, frame(epoch)));
    say(ack(depart(state, frame(epoch), now).seq));
    ++sent;
  }
  EXPECT_EQ(sent, 50);
}

TEST_F(StateTest, ConvergenceIsToldOnceAndTakenBackWithTheNextEpoch) {
  say(hello());
  began(state, 1, state.wanted);
  FrameInfo last = frame(1);
  admit(state, last);
  EXPECT_FALSE(depart(state, last, now).state);
  last.converged = true;
  admit(state, last);
  const Departure told = depart(state, last, now);
  ASSERT_TRUE(told.state);
  EXPECT_TRUE(told.state->converged());
  say(ack(2));
  began(state, 2, state.wanted);
  admit(state, frame(2));
  const Departure again = depart(state, frame(2), now);
  ASSERT_TRUE(again.state);
  EXPECT_FALSE(again.state->converged());
  EXPECT_EQ(again.state->epoch(), 2U);
}

TEST_F(StateTest, LatencyIsMeasuredFromTheOldestInputThatNoFrameHasShown) {
  say(hello());
  say(turned(1));
  now += milliseconds(10);
  say(turned(2));
  began(state, 1, state.wanted);
  now += milliseconds(10);
  admit(state, frame(1, true, 2));
  const Departure departure = depart(state, frame(1, true, 2), now);
  ASSERT_TRUE(departure.input_to_frame);
  EXPECT_NEAR(*departure.input_to_frame, 0.020, 1e-9);
  admit(state, frame(1, false, 2));
  EXPECT_FALSE(depart(state, frame(1, false, 2), now).input_to_frame);
}

TEST_F(StateTest, NobodyWatchesWhatIsHiddenDetachedOrNotAcknowledged) {
  EXPECT_FALSE(watched(state, now)) << "not greeted";
  say(hello());
  EXPECT_TRUE(watched(state, now));
  v1::ClientMessage message;
  message.mutable_visibility()->set_visible(false);
  say(message);
  EXPECT_FALSE(watched(state, now));
  message.mutable_visibility()->set_visible(true);
  state.wanted.picture_again = false;
  say(message);
  EXPECT_TRUE(watched(state, now));
  EXPECT_TRUE(state.wanted.picture_again);

  began(state, 1, state.wanted);
  admit(state, frame(1));
  depart(state, frame(1), now);
  now += kStalledAfter + milliseconds(1);
  EXPECT_FALSE(watched(state, now));
  say(ack(1));
  EXPECT_TRUE(watched(state, now));
  detach(state, now);
  EXPECT_FALSE(watched(state, now));
  EXPECT_EQ(admit(state, frame(1)), Admission::kDrop);
}

TEST_F(StateTest, AnAttachedViewerStartsWithAFrameOfWhatThereIs) {
  say(hello());
  began(state, 5, state.wanted);
  admit(state, frame(5));
  depart(state, frame(5), now);
  detach(state, now);
  state.wanted.picture_again = false;
  attach(state, now);
  EXPECT_EQ(admit(state, frame(5, false)), Admission::kWait) << "not greeted yet";
  EXPECT_TRUE(say(hello()).configure);
  EXPECT_TRUE(state.wanted.picture_again);
  ASSERT_EQ(admit(state, frame(5, false)), Admission::kGo);
  EXPECT_EQ(depart(state, frame(5, false), now).seq, 1U);
}

/// The switch of the denoiser changes the picture, so it is a new version of what is wanted.
TEST(SessionState, RawPicturesAreWantedOnlyWhereAskedFor) {
  SessionState state;
  const TimePoint now{};
  attach(state, now);
  ASSERT_FALSE(receive(state, hello(), now).problem);
  ASSERT_FALSE(receive(state, turned(1), now).problem);
  EXPECT_FALSE(state.wanted.raw);
  const std::uint64_t version = state.wanted.version;
  v1::ClientMessage raw = turned(1);
  raw.mutable_scene()->set_input_seq(2);
  raw.mutable_scene()->set_raw(true);
  ASSERT_FALSE(receive(state, raw, now).problem);
  EXPECT_TRUE(state.wanted.raw);
  EXPECT_EQ(state.wanted.version, version + 1);
}

}  // namespace
}  // namespace diaphane::render
