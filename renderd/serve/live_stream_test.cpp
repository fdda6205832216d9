// The stream of a live session, including encoders, as a viewer receives it.
#include <gtest/gtest.h>
#include <sodium.h>

#include "renderd/serve/session_host.h"
#include "tests/support/renderd/test_worker.h"

namespace diaphane::render {
namespace {

using Kind = v1::ServerMessage;

struct LiveStream : WorkerTest, TestViewer {
  LiveStream() {
    device->seconds_per_megapixel = 0.01;
    options.runner.rules.target_error = 0.05;  // of the fake renderer: 100 samples
    start_worker();
  }
  void greet(v1::Codec codec, std::uint32_t side, v1::StillFormat stills) {
    attachment = *worker->host().open(open_message(new_id(), store.add_ball()), link);
    v1::ClientMessage hello = hello_message(side);
    hello.mutable_hello()->clear_codecs();
    hello.mutable_hello()->add_codecs(codec);
    hello.mutable_hello()->add_codecs(v1::JPEG);
    if (stills != v1::STILL_FORMAT_UNSPECIFIED) hello.mutable_hello()->add_stills(stills);
    say(hello);
    config = link->inbox.next_of(Kind::kConfig)->config();
  }
  /// Returns the next message that a page handles. Acknowledges pictures.
  std::optional<v1::ServerMessage> next() {
    auto message = link->inbox.next([](const auto&) { return true; });
    if (message && message->has_frame()) say(ack_message(message->frame().seq()));
    if (message && message->has_still()) say(ack_message(message->still().seq()));
    return message;
  }
  /// Returns all messages up to the first one that passes.
  std::vector<v1::ServerMessage> until(const std::function<bool(const v1::ServerMessage&)>& test) {
    std::vector<v1::ServerMessage> all;
    for (auto message = next(); message; message = next()) {
      all.push_back(*message);
      if (test(all.back())) return all;
    }
    ADD_FAILURE() << "it never came";
    return all;
  }

  v1::Config config;
};

bool is_lossless(const v1::ServerMessage& message) {
  return message.has_state() && message.state().lossless();
}

TEST_F(LiveStream, UsesTheFirstSupportedCodecAndStartsWithAKeyFrame) {
  greet(v1::H264, 64, v1::STILL_FORMAT_UNSPECIFIED);
  EXPECT_EQ(config.codec(), v1::H264);
  const auto all =
      until([](const auto& message) { return message.has_state() && message.state().converged(); });
  bool first = true;
  for (const v1::ServerMessage& message : all) {
    if (!message.has_frame()) continue;
    const v1::Frame& frame = message.frame();
    EXPECT_EQ(frame.codec(), v1::H264);
    if (first) EXPECT_TRUE(frame.key());
    EXPECT_EQ(frame.key(), !frame.decoder().empty());
    EXPECT_NE(frame.quality(), v1::FRAME_QUALITY_UNSPECIFIED);
    first = false;
  }
  EXPECT_FALSE(first);
  EXPECT_FALSE(link->inbox.count(Kind::kStill)) << "it shows none";
}

TEST_F(LiveStream, SendsKeyFrameOnRequest) {
  greet(v1::MPEG1, 64, v1::STILL_FORMAT_UNSPECIFIED);
  until([](const auto& message) { return message.has_state(); });
  std::this_thread::sleep_for(kKeyEvery);
  v1::ClientMessage need;
  need.mutable_need_key();
  say(need);
  until([](const auto& message) { return message.has_frame() && message.frame().key(); });
}

TEST_F(LiveStream, ConvergenceSendsTilesOfTheWholeImageAndTheMark) {
  greet(v1::JPEG, 600, v1::WEBP);
  const auto all = until(is_lossless);
  std::uint64_t seq = 0;
  std::uint32_t tile = 0;
  std::uint64_t pixels = 0;
  std::uint64_t epoch = 0;
  for (const v1::ServerMessage& message : all) {
    if (message.has_frame()) {
      EXPECT_EQ(message.frame().seq(), ++seq);
      EXPECT_EQ(tile, 0U) << "tiles come after the last frame";
      epoch = message.frame().epoch();
    }
    if (!message.has_still()) continue;
    const v1::Still& still = message.still();
    EXPECT_EQ(still.seq(), ++seq);
    EXPECT_EQ(still.epoch(), epoch);
    EXPECT_EQ(still.tile(), tile++);
    EXPECT_EQ(still.tiles(), 9U);
    EXPECT_EQ(still.format(), v1::WEBP);
    EXPECT_EQ(still.hash().size(), crypto_hash_sha256_BYTES);
    EXPECT_GT(still.iteration(), 0U);
    pixels += std::uint64_t{still.width()} * still.height();
  }
  EXPECT_EQ(tile, 9U);
  EXPECT_EQ(pixels, 600U * 600U);
  EXPECT_EQ(all.back().state().epoch(), epoch);
}

TEST_F(LiveStream, NewInputReplacesTheTilesByItsOwn) {
  greet(v1::H264, 600, v1::PNG);
  until([](const auto& message) { return message.has_still(); });
  say(scene_message(1, turned(config.scene(), 40)));
  bool moved = false;
  const auto all = until([&](const auto& message) {
    moved = moved || (message.has_frame() && message.frame().input_seq() == 1);
    return moved && is_lossless(message);
  });
  std::uint64_t epoch = 0;
  std::uint32_t tiles = 0;
  for (const v1::ServerMessage& message : all) {
    if (message.has_frame()) {
      EXPECT_GE(message.frame().epoch(), epoch);
      epoch = message.frame().epoch();
    }
    if (message.has_still()) {
      EXPECT_EQ(message.still().epoch() < epoch, false) << "an outdated tile";
      tiles += message.still().epoch() == all.back().state().epoch();
    }
  }
  EXPECT_EQ(tiles, 9U);
}

TEST_F(LiveStream, AnswersDepthQuery) {
  greet(v1::JPEG, 64, v1::STILL_FORMAT_UNSPECIFIED);
  until([](const auto& message) { return message.has_frame(); });
  v1::ClientMessage query;
  query.mutable_depth_query()->set_id(5);
  query.mutable_depth_query()->set_x(0.5);
  query.mutable_depth_query()->set_y(0.5);
  say(query);
  const v1::Depth ball =
      until([](const auto& message) { return message.has_depth(); }).back().depth();
  EXPECT_EQ(ball.id(), 5U);
  ASSERT_TRUE(ball.found());
  // 24 voxels of 4 mm, with a radius of 0.35 of them.
  const auto& place = ball.place();
  EXPECT_NEAR(std::hypot(place.x(), place.y(), place.z()), 0.35 * 96, 6);
  const auto& eye = config.scene().camera().eye();
  EXPECT_NEAR(ball.distance(), std::hypot(eye.x(), eye.y(), eye.z()) - 0.35 * 96, 6);
  std::this_thread::sleep_for(kDepthEvery);
  query.mutable_depth_query()->set_x(0);
  query.mutable_depth_query()->set_y(0);
  say(query);
  EXPECT_FALSE(
      until([](const auto& message) { return message.has_depth(); }).back().depth().found());
}

}  // namespace
}  // namespace diaphane::render
