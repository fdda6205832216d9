#include "renderd/session/free_cameras.h"

#include <gtest/gtest.h>

#include "tests/support/renderd/effects_in_test.h"
#include "tests/support/renderd/test_messages.h"

namespace diaphane::render {
namespace {

using effect::DismissCamera;
using effect::EnterCamera;
using effect::OpenCamera;
using effect::Send;
using effect::SilenceCamera;

struct FreeCamerasTest : testing::Test {
  FreeCamerasTest() {
    const auto scene = plain_scene();
    state.requested.scene = std::make_shared<const v1::Scene>(scene);
    receive(state, attach(state, owner(), now)->connection, hello(), now);
    JoinRequest join;
    join.participant = "guest";
    follower = attach(state, join, now)->connection;
    receive(state, follower, hello(320, 200), now);
    cameras.handle(SceneChanged{}, state);
  }
  Effects open() { return cameras.handle(CameraRequested{follower, true}, state); }
  Effects opened(CameraOpened event) { return cameras.handle(event, state, now); }
  void enter() {
    open();
    opened({follower, "own", std::uint64_t{1}});
  }

  TimePoint now{};
  SessionState state;
  FreeCameras cameras;
  std::uint64_t follower = 0;
};

TEST_F(FreeCamerasTest, OpensSessionInSizeOfFollowerAndEntersIt) {
  const auto requested = sole<OpenCamera>(open());
  EXPECT_EQ(requested.participant, "guest");
  EXPECT_EQ(requested.viewport, (Canvas{320, 200}));
  EXPECT_EQ(requested.scene, state.requested.scene);
  EXPECT_FALSE(cameras.of(follower));
  const auto entered = sole<EnterCamera>(opened({follower, "own", std::uint64_t{7}}));
  EXPECT_EQ(entered.session, "own");
  EXPECT_EQ(entered.connection, 7u);
  EXPECT_EQ(entered.hello.hello().viewport().width(), 320u);
  EXPECT_TRUE(state.audience.find(follower)->free_camera);
  EXPECT_EQ(cameras.of(follower)->session, "own");
}

TEST_F(FreeCamerasTest, FollowersLearnOfScenesInOrder) {
  enter();
  EXPECT_TRUE(cameras.handle(SceneChanged{}, state).empty());
  state.requested.scene = std::make_shared<const v1::Scene>(plain_scene());
  const auto first = sole<effect::FollowPresenter>(cameras.handle(SceneChanged{}, state));
  state.requested.scene = std::make_shared<const v1::Scene>(plain_scene());
  const auto second = sole<effect::FollowPresenter>(cameras.handle(SceneChanged{}, state));
  EXPECT_EQ(second.session, "own");
  EXPECT_EQ(second.scene, state.requested.scene);
  EXPECT_GT(second.number, first.number);
}

TEST_F(FreeCamerasTest, ReturnsToGroupOnlyAfterOwnSessionIsSilent) {
  enter();
  const auto silence = sole<SilenceCamera>(cameras.handle(CameraRequested{follower, false}, state));
  EXPECT_TRUE(state.audience.find(follower)->free_camera);
  EXPECT_TRUE(cameras.handle(CameraRequested{follower, false}, state).empty());
  const Effects back = cameras.handle(CameraSilenced{silence.connection, silence.why}, state, now);
  EXPECT_FALSE(state.audience.find(follower)->free_camera);
  EXPECT_EQ(only<effect::Configure>(back).size(), 1u);
  EXPECT_EQ(only<effect::BroadcastParticipants>(back).size(), 1u);
  EXPECT_TRUE(only<Send>(back).empty());
}

TEST_F(FreeCamerasTest, FollowerLearnsWhyTheirSlotWasTakenBeforeTheyAreConfigured) {
  enter();
  const Error why{ErrorCode::kTooMany, "Taken.", "own_camera_taken"};
  EXPECT_TRUE(cameras.handle(CameraWithdrawn{"another", why}).empty());
  const auto silence = sole<SilenceCamera>(cameras.handle(CameraWithdrawn{"own", why}));
  EXPECT_TRUE(cameras.handle(ViewerLeft{silence.connection}).empty()) << "nothing to dismiss";
  const Effects back = cameras.handle(CameraSilenced{silence.connection, silence.why}, state, now);
  ASSERT_TRUE(std::holds_alternative<Send>(back.front()));
  EXPECT_EQ(std::get<Send>(back.front()).message.problem().field(), "own_camera_taken");
}

TEST_F(FreeCamerasTest, DismissesSessionThatNobodyCanEnter) {
  open();
  state.audience.presenter = "guest";
  EXPECT_EQ(sole<DismissCamera>(opened({follower, "own", std::uint64_t{1}})).session, "own");
  state.audience.presenter = kOwner;
  EXPECT_EQ(sole<DismissCamera>(opened({follower, "own", std::uint64_t{1}, false, true})).session,
            "own");
  const Effects withdrawn = opened({follower, "own", std::uint64_t{1}, true});
  EXPECT_EQ(only<Send>(withdrawn)[0].message.problem().field(), "own_camera");
  EXPECT_EQ(only<DismissCamera>(withdrawn).size(), 1u);
  EXPECT_FALSE(state.audience.find(follower)->free_camera);
}

TEST_F(FreeCamerasTest, ReportsWhyNoSessionWasAvailable) {
  open();
  const Error none{ErrorCode::kTooMany, "None.", "own_camera"};
  const auto problem = sole<Send>(opened({follower, {}, tl::unexpected(none)}));
  EXPECT_EQ(problem.message.problem().field(), "own_camera");
}

TEST_F(FreeCamerasTest, DismissesSessionsWithFollowerAndWithGroup) {
  enter();
  EXPECT_EQ(sole<DismissCamera>(cameras.handle(ViewerLeft{follower})).session, "own");
  EXPECT_TRUE(cameras.handle(SessionEnded{}).empty());
  opened({follower, "next", std::uint64_t{1}});
  EXPECT_EQ(sole<DismissCamera>(cameras.handle(SessionEnded{})).session, "next");
}

}  // namespace
}  // namespace diaphane::render
