#include "renderd/session/lossless_tiles.h"

#include <gtest/gtest.h>

#include "tests/support/renderd/effects_in_test.h"
#include "tests/support/renderd/test_messages.h"

namespace diaphane::render {
namespace {

using effect::CodeTile;
using effect::Send;

constexpr std::uint32_t kTiles = 4;

struct LosslessTilesTest : testing::Test {
  LosslessTilesTest() {
    state.requested.scene = std::make_shared<const v1::Scene>(plain_scene());
    viewer = enter("owner");
    info.epoch = state.epoch = 1;
    info.samples = 9;
    info.first_of_epoch = info.converged = true;
  }
  std::uint64_t enter(const std::string& participant) {
    JoinRequest join = owner();
    join.participant = participant;
    const auto connection = attach(state, join, now)->connection;
    v1::ClientMessage greeting = hello();
    greeting.mutable_hello()->add_stills(v1::PNG);
    receive(state, connection, greeting, now);
    return connection;
  }
  // All viewers receive the frame, and acknowledge it.
  Effects finish_picture() {
    admit(state, v1::JPEG, info, now);
    for (const auto& frame : depart(state, v1::JPEG, info, {true, 100}, now).frames) {
      receive(state, frame.connection, ack(frame.seq), now);
    }
    tiles.handle(PictureFinished{info, picture, kTiles}, state);
    return room();
  }
  Effects room() { return tiles.handle(RoomForTiles{}, state, now); }
  Effects coded(const CodeTile& of) {
    v1::Still still;
    still.set_format(of.format);
    still.set_data("data");
    return tiles.handle(TileCoded{of.picture, of.tile, still}, state, now);
  }

  TimePoint now = TimePoint() + std::chrono::seconds(100);
  SessionState state;
  LosslessTiles tiles;
  PictureRgb8 picture;
  FrameInfo info;
  std::uint64_t viewer = 0;
};

TEST_F(LosslessTilesTest, CodesEachTileOnceAndOneAheadForAllViewers) {
  enter("guest");
  const auto first = only<CodeTile>(finish_picture());
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(first[0].tile, 0u);
  EXPECT_EQ(first[1].tile, 1u);
  const Effects effects = coded(first[0]);
  EXPECT_EQ(only<Send>(effects).size(), 2u);  // one for each viewer
  const auto next = only<CodeTile>(effects);
  ASSERT_EQ(next.size(), 1u);
  EXPECT_EQ(next[0].tile, 2u);
  EXPECT_TRUE(only<CodeTile>(room()).empty());
}

TEST_F(LosslessTilesTest, SendsAllTilesInOrderAndThenTheMark) {
  std::vector<CodeTile> under_way = only<CodeTile>(finish_picture());
  std::vector<v1::ServerMessage> sent;
  while (!under_way.empty()) {
    std::vector<CodeTile> next;
    for (const CodeTile& one : under_way) {
      Effects effects = coded(one);
      for (const auto& send : only<Send>(effects)) {
        sent.push_back(send.message);
        if (send.message.has_still()) {
          receive(state, viewer, ack(send.message.still().seq()), now);
        }
      }
      for (const auto& more : only<CodeTile>(effects)) next.push_back(more);
    }
    under_way = next;
  }
  ASSERT_EQ(sent.size(), kTiles + 1);
  for (std::uint32_t i = 0; i < kTiles; ++i) {
    EXPECT_EQ(sent[i].still().tile(), i);
    EXPECT_EQ(sent[i].still().tiles(), kTiles);
    EXPECT_EQ(sent[i].still().iteration(), 9u);
    EXPECT_EQ(sent[i].still().data(), "data");
  }
  EXPECT_TRUE(sent.back().state().lossless());
}

TEST_F(LosslessTilesTest, ForgetsPictureWithItsEpoch) {
  const auto order = only<CodeTile>(finish_picture());
  tiles.handle(EpochBegan{});
  EXPECT_TRUE(order[0].pixels.expired());
  EXPECT_TRUE(coded(order[0]).empty());
  EXPECT_TRUE(room().empty());
}

TEST_F(LosslessTilesTest, StopsAfterATileThatCannotBeEncoded) {
  const auto order = only<CodeTile>(finish_picture());
  EXPECT_TRUE(tiles.handle(TileCoded{order[0].picture, 0, std::nullopt}, state, now).empty());
  EXPECT_TRUE(coded(order[1]).empty());
}

TEST_F(LosslessTilesTest, KeepsOnlyPictureThatIsFinishedAtRest) {
  info.moving = true;
  EXPECT_TRUE(finish_picture().empty());
  info.moving = false;
  info.converged = false;
  EXPECT_TRUE(finish_picture().empty());
  state.audience.find(viewer)->stills = v1::STILL_FORMAT_UNSPECIFIED;
  info.converged = true;
  EXPECT_TRUE(finish_picture().empty());
}

}  // namespace
}  // namespace diaphane::render
