// What follows the frames of a viewer: the lossless picture, and changes of the connection.
#include <google/protobuf/io/coded_stream.h>
#include <gtest/gtest.h>

#include "tests/support/renderd/test_messages.h"

namespace diaphane::render {
namespace {

using std::chrono::milliseconds;

struct StreamTest : testing::Test {
  StreamTest() {
    state.codecs = {v1::H264, v1::JPEG};
    state.requested.scene = std::make_shared<const v1::Scene>(plain_scene());
    state.requested.viewport = {1280, 720};
    state.requested.version = 1;
    owner = join(std::string(kOwner), {v1::WEBP, v1::PNG});
    began(state, 1, state.requested);
  }
  std::uint64_t join(const std::string& participant, const std::vector<v1::StillFormat>& stills,
                     v1::Codec codec = v1::JPEG) {
    const auto attached = attach(state, {participant, "", "", ViewerKind::kOwner}, now);
    v1::ClientMessage message = hello(1280, 720);
    message.mutable_hello()->clear_codecs();
    message.mutable_hello()->add_codecs(codec);
    for (const v1::StillFormat format : stills) message.mutable_hello()->add_stills(format);
    EXPECT_TRUE(receive(state, attached->connection, message, now).configure);
    return attached->connection;
  }
  /// Encodes a picture and sends it to all takers.
  Admitted send(const FrameInfo& info, std::size_t bytes = 10000, v1::Codec codec = v1::JPEG) {
    const Admitted admitted = admit(state, codec, info, now);
    if (admitted.admission == Admission::kGo) {
      for (const OutgoingFrame& one :
           depart(state, codec, info, {admitted.key || codec == v1::JPEG, bytes}, now).frames) {
        newest[one.connection] = one.seq;
        sent_state = one.state;
      }
    }
    return admitted;
  }
  void hear(std::uint64_t connection) { receive(state, connection, ack(newest[connection]), now); }
  std::vector<TileDue> due() { return tiles_due(state, last, kTiles, now); }
  std::optional<v1::State> send_tile(const TileDue& tile, std::size_t bytes = 30000) {
    const OutgoingFrame outgoing = depart_tile(state, tile, kTiles, bytes, now);
    newest[tile.connection] = outgoing.seq;
    return outgoing.state;
  }
  /// Simulates a connection that takes `seconds` for each of 40 frames of `bytes`.
  void learn(std::uint64_t connection, double seconds, std::size_t bytes) {
    Receiver& receiver = *state.audience.find(connection);
    for (int i = 0; i < 40; ++i) {
      const FrameInfo info = frame(1, false);
      if (send(info, bytes).admission != Admission::kGo) ADD_FAILURE();
      now += std::chrono::microseconds(static_cast<int>(seconds * 1e6));
      for (Receiver& one : state.audience.receivers) hear(one.connection);
    }
    EXPECT_TRUE(receiver.path.known());
  }

  static constexpr std::uint32_t kTiles = 15;
  SessionState state;
  TimePoint now = TimePoint{} + std::chrono::hours(1);
  std::uint64_t owner = 0;
  std::map<std::uint64_t, std::uint64_t> newest;
  std::optional<v1::State> sent_state;
  FrameInfo last = [] {
    FrameInfo info = frame(1, false);
    info.converged = true;
    return info;
  }();
};

TEST_F(StreamTest, SendsTilesInOrderThenTheMarkAfterConvergence) {
  send(frame(1));
  hear(owner);
  EXPECT_TRUE(due().empty()) << "the converged frame comes first";
  send(last);
  EXPECT_TRUE(sent_state && sent_state->converged() && !sent_state->lossless());
  std::optional<v1::State> mark;
  for (std::uint32_t tile = 0; tile < kTiles; ++tile) {
    EXPECT_FALSE(mark);
    const auto next = due();
    ASSERT_EQ(next.size(), 1U) << tile;
    EXPECT_EQ(next[0].tile, tile);
    EXPECT_EQ(next[0].format, v1::WEBP);
    const std::uint64_t before = newest[owner];
    mark = send_tile(next[0]);
    EXPECT_EQ(newest[owner], before + 1) << "counted with the frames";
    hear(owner);
  }
  ASSERT_TRUE(mark);
  EXPECT_TRUE(mark->lossless());
  EXPECT_EQ(mark->epoch(), 1U);
  EXPECT_TRUE(due().empty());
}

TEST_F(StreamTest, TilesWaitForRoomLikeFrames) {
  send(last);
  send_tile(due().at(0));
  EXPECT_TRUE(due().empty()) << "a frame and a tile are on their way";
  hear(owner);
  EXPECT_EQ(due().size(), 1U);
}

TEST_F(StreamTest, NewEpochDropsRemainingTiles) {
  send(last);
  hear(owner);
  send_tile(due().at(0));
  began(state, 2, state.requested);
  EXPECT_TRUE(due().empty());
  EXPECT_EQ(send(frame(2)).admission, Admission::kGo);
  EXPECT_TRUE(sent_state && !sent_state->converged()) << "the mark is taken back";
}

TEST_F(StreamTest, ResentFrameIsFollowedByAllTilesAndTheMark) {
  send(last);
  hear(owner);
  for (std::uint32_t tile = 0; tile < kTiles; ++tile) {
    send_tile(due().at(0));
    hear(owner);
  }
  last.input_seq = 7;  // an input without a change
  send(last);
  EXPECT_TRUE(sent_state && sent_state->converged() && !sent_state->lossless());
  ASSERT_EQ(due().size(), 1U);
  EXPECT_EQ(due()[0].tile, 0U);
}

TEST_F(StreamTest, SendsTilesAtThePaceOfEachCapableViewer) {
  const std::uint64_t other = join("guest-a", {v1::PNG});
  join("guest-b", {});
  send(last);
  hear(owner);
  const auto both = due();
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(both[1].format, v1::PNG);
  send_tile(both[0]);
  send_tile(both[1]);
  hear(owner);
  const auto next = due();  // the other viewer has a frame and a tile in transit
  ASSERT_EQ(next.size(), 1U);
  EXPECT_EQ(next[0].connection, owner);
  EXPECT_EQ(next[0].tile, 1U);
  hear(other);
  EXPECT_EQ(due().size(), 2U);
}

TEST_F(StreamTest, OnlyThePresentersConnectionReducesResolutionWhileMoving) {
  const std::uint64_t other = join("guest-a", {});
  learn(owner, 0.01, 100000);
  EXPECT_EQ(state.requested.moving_scale, 1);
  // Only the follower answers late.
  for (int i = 0; i < 40; ++i) {
    send(frame(1, false), 100000);
    now += milliseconds(10);
    hear(owner);
    if (i % 20 == 19) hear(other);
  }
  EXPECT_EQ(state.requested.moving_scale, 1);
  learn(owner, 0.5, 60000);
  EXPECT_LT(state.requested.moving_scale, 1);
}

TEST_F(StreamTest, SizesFramesForThePresentersConnection) {
  const std::uint64_t other = join("guest-a", {});
  EXPECT_EQ(send(frame(1)).moving_bytes, 0U) << "nothing is known";
  hear(owner);
  hear(other);
  learn(owner, 0.01, 100000);
  const Admitted fast = send(frame(1, false));
  EXPECT_GT(fast.moving_bytes, 50000U);
  EXPECT_GT(fast.settled_bytes, fast.moving_bytes);
}

// 25 frames of 10 KB per second, two at a time, do not fill a connection that answers after 100 ms.
TEST_F(StreamTest, LongRoundTripAllowsMoreFramesInFlightWithBoundedBytes) {
  Receiver& receiver = *state.audience.find(owner);
  std::vector<std::pair<TimePoint, std::uint64_t>> coming;
  std::uint64_t most_frames = 0;
  std::size_t most_bytes = 0;
  for (int i = 0; i < 5000; ++i, now += milliseconds(1)) {
    while (!coming.empty() && coming.front().first <= now) {
      receive(state, owner, ack(coming.front().second), now);
      coming.erase(coming.begin());
    }
    // 8 Mbit/s: each frame takes 10 ms after the previous one.
    if (i % 16 == 0 && send(frame(1, false), 10000).admission == Admission::kGo) {
      const TimePoint after = coming.empty() ? now : coming.back().first - milliseconds(100);
      coming.emplace_back(std::max(after, now) + milliseconds(110), newest[owner]);
    }
    most_frames = std::max(most_frames, receiver.flight.unacknowledged());
    most_bytes = std::max(most_bytes, receiver.path.bytes_in_flight());
  }
  EXPECT_GT(most_frames, 2U);
  EXPECT_LT(most_bytes, 250000U) << "a quarter of a second";
}

// No message of the stream has more than a dozen levels. Unknown groups nest without a schema, and
// messages are parsed recursively, so only this limit protects the stack.
TEST(StreamMessage, RefusesNestingBeyondAHundredLevels) {
  const auto nested = [](std::size_t levels) {
    constexpr char kBegin = 15 << 3 | 3, kEnd = 15 << 3 | 4;  // of the unknown group 15
    return std::string(levels, kBegin) + std::string(levels, kEnd);
  };
  EXPECT_EQ(google::protobuf::io::CodedInputStream::GetDefaultRecursionLimit(), 100);
  v1::ClientMessage said;
  v1::ServerMessage answer;
  v1::Scene kept;
  EXPECT_TRUE(said.ParseFromString(nested(99)));
  for (const std::size_t levels : {101U, 30'000U}) {
    EXPECT_FALSE(said.ParseFromString(nested(levels))) << levels;
    EXPECT_FALSE(answer.ParseFromString(nested(levels))) << levels;
    EXPECT_FALSE(kept.ParseFromString(nested(levels))) << levels;
  }
}

}  // namespace
}  // namespace diaphane::render
