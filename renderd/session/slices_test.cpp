#include "renderd/session/slices.h"

#include <gtest/gtest.h>

#include "tests/support/renderd/effects_in_test.h"
#include "tests/support/renderd/test_messages.h"

namespace diaphane::render {
namespace {

using effect::CodeSlice;
using effect::LoadVoxels;
using effect::Send;

struct SlicesTest : testing::Test {
  SlicesTest() {
    volume::Volume voxels;
    voxels.header.size = {30, 20, 10};
    voxels.header.content_hash = "hash";
    volume = std::make_shared<const HostVolume>(std::move(voxels));
    slices.handle(SlicesKnown{stacks_of(volume->header())});
    state.requested.scene = std::make_shared<const v1::Scene>(plain_scene());
    connection = attach(state, owner(), now)->connection;
    slices.handle(SceneChanged{}, state);
  }
  std::uint64_t guest() {
    JoinRequest join;
    join.participant = "guest";
    state.audience.guest_slices = state.audience.slices_shown = true;
    return attach(state, join, now)->connection;
  }
  Effects ask(std::uint64_t from, std::uint32_t index) {
    v1::SliceRequest request;
    request.add_slices()->set_plane(v1::AXIAL);
    request.mutable_slices(0)->set_index(index);
    return slices.handle(SlicesRequested{from, request}, state, now);
  }
  Effects load(const std::string& hash = "hash") {
    return slices.handle(VoxelsLoaded{volume, hash}, state, now);
  }
  Effects coded(const CodeSlice& of) {
    return slices.handle(SliceCoded{of.connection, of.order, std::string("data")}, state, now);
  }
  void clip_scene() {
    v1::Scene clipped = *state.requested.scene;
    clipped.mutable_clip()->mutable_box_low()->set_x(1);
    state.requested.scene = std::make_shared<const v1::Scene>(clipped);
  }

  TimePoint now = TimePoint() + std::chrono::seconds(100);
  SessionState state;
  Slices slices;
  std::shared_ptr<const HostVolume> volume;
  std::uint64_t connection = 0;
};

TEST_F(SlicesTest, LoadsVoxelsOnceAndThenCodesWhatEachViewerWaitsFor) {
  const std::uint64_t other = guest();
  sole<LoadVoxels>(ask(connection, 3));
  EXPECT_TRUE(ask(other, 4).empty());
  const auto orders = only<CodeSlice>(load());
  ASSERT_EQ(orders.size(), 2u);
  EXPECT_EQ(orders[0].connection, connection);
  EXPECT_EQ(orders[0].order.due.index, 3u);
  EXPECT_FALSE(orders[0].for_guest);
  EXPECT_FALSE(orders[0].order.clip);
  EXPECT_EQ(orders[1].connection, other);
  EXPECT_TRUE(orders[1].for_guest);
  EXPECT_TRUE(orders[1].order.clip);
}

TEST_F(SlicesTest, SendsCodedSliceAndTakesNewestRequestNext) {
  ask(connection, 3);
  const auto first = sole<CodeSlice>(load());
  EXPECT_TRUE(ask(connection, 5).empty());  // one at a time
  const Effects effects = coded(first);
  const auto sent = only<Send>(effects);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].message.slice().index(), 3u);
  EXPECT_EQ(sent[0].message.slice().data(), "data");
  ASSERT_EQ(only<CodeSlice>(effects).size(), 1u);
  EXPECT_EQ(only<CodeSlice>(effects)[0].order.due.index, 5u);
}

TEST_F(SlicesTest, RebuildsSliceIfTheClipChangedMeanwhile) {
  const std::uint64_t other = guest();
  ask(other, 3);
  const auto order = sole<CodeSlice>(load());
  clip_scene();
  const auto again = sole<CodeSlice>(coded(order));
  EXPECT_EQ(again.order.due.index, 3u);
  EXPECT_TRUE(again.order.clip->has_box_low());
}

TEST_F(SlicesTest, SendsNothingToGuestsWithoutSliceAccess) {
  const std::uint64_t other = guest();
  ask(other, 3);
  const auto order = sole<CodeSlice>(load());
  state.audience.guest_slices = false;
  EXPECT_TRUE(coded(order).empty());
}

TEST_F(SlicesTest, NotifiesOnlyViewersWithClippedSlicesOfStaleOnes) {
  const std::uint64_t other = guest();
  ask(other, 3);
  coded(sole<CodeSlice>(load()));
  EXPECT_TRUE(slices.handle(SceneChanged{}, state).empty());
  clip_scene();
  const auto stale = sole<Send>(slices.handle(SceneChanged{}, state));
  EXPECT_EQ(stale.connection, other);
  EXPECT_TRUE(stale.message.has_slices_stale());
}

TEST_F(SlicesTest, RefusesVoxelsOfReplacedVolume) {
  ask(connection, 3);
  const Effects effects = load("other hash");
  ASSERT_EQ(only<Send>(effects).size(), 1u);
  EXPECT_EQ(only<Send>(effects)[0].message.problem().field(), "slices");
  EXPECT_EQ(only<effect::Warn>(effects).size(), 1u);
  sole<LoadVoxels>(ask(connection, 3));
}

TEST_F(SlicesTest, ForgetsVoxelsWithLastViewer) {
  ask(connection, 3);
  load();
  slices.handle(AllViewersLeft{});
  sole<LoadVoxels>(ask(connection, 4));
}

TEST_F(SlicesTest, RequestOverItsLimitWaitsForTick) {
  ask(connection, 0);
  CodeSlice order = sole<CodeSlice>(load());
  Effects next;
  std::uint64_t sent = 0;
  do {
    v1::SliceRequest request;
    request.add_slices()->set_plane(v1::AXIAL);
    request.mutable_slices(0)->set_index(order.order.due.index == 0 ? 1 : 0);
    coded(order);
    request.set_taken(++sent);
    next = slices.handle(SlicesRequested{connection, request}, state, now);
    if (!next.empty()) order = sole<CodeSlice>(next);
  } while (!next.empty() && sent < 1000);
  EXPECT_EQ(sent, SliceAllowance::kMostASecond);
  EXPECT_TRUE(slices.handle(SlicesTicked{}, state, now).empty());
  now += std::chrono::seconds(1);
  sole<CodeSlice>(slices.handle(SlicesTicked{}, state, now));
}

}  // namespace
}  // namespace diaphane::render
