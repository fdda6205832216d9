#include <gmock/gmock.h>

#include <fstream>
#include <utility>
#include <vector>

#include "api/redis/test_sessions.h"

namespace diaphane::api::redis {
namespace {

/// A worker's heartbeat, run as renderd runs it; the sessions that it is told to end.
class HeartbeatTest : public SessionsTest {
 protected:
  using Live = std::vector<std::pair<std::string, std::string>>;  // session id, placement
  std::vector<std::string> beat(const std::string& worker, const std::string& incarnation,
                                const Live& live) {
    std::ifstream file(HEARTBEAT_LUA);
    const std::string source((std::istreambuf_iterator<char>(file)), {});
    const std::string hash = "diaphane:worker:" + worker, entries = hash + ":sessions";
    Arguments words{"EVAL",
                    source,
                    "3",
                    "diaphane:workers",
                    hash,
                    entries,
                    worker,
                    incarnation,
                    "host:1",
                    "cpu",
                    "test",
                    "2",
                    "0",
                    "0.5",
                    "0.4",
                    "",
                    "diaphane:session:",
                    ""};  // no session is a visitor's
    for (const auto& [id, placement] : live) words.insert(words.end(), {id, placement});
    const Result<Reply> reply = client_->command(words);
    std::vector<std::string> ended;
    if (!reply) {
      ADD_FAILURE() << reply.error().message;
      return ended;
    }
    for (const Reply& id : reply->list) {
      if (id.text.empty()) break;  // sessions that Redis does not know follow
      ended.push_back(id.text);
    }
    return ended;
  }
};

TEST_F(HeartbeatTest, ABeatingWorkerIsPlacedOnAndItsLiveSessionsHoldTheirSlots) {
  beat("a", "one", {});
  const PlaceRequest first = request(), second = request();
  ASSERT_TRUE(sessions_.place(first));
  ASSERT_TRUE(sessions_.place(second));
  EXPECT_TRUE(beat("a", "one", {{first.session_id, "1"}, {second.session_id, "1"}}).empty());
  EXPECT_EQ(sessions_.place(request()).error().code, ErrorCode::kUnavailable);
  EXPECT_TRUE(beat("a", "one", {{first.session_id, "1"}}).empty());
  EXPECT_TRUE(sessions_.place(request())) << "a session that the worker ended frees its slot";
}

TEST_F(HeartbeatTest, WhatAWorkerExpectsIsOfTheSessionsThatItHasHeardOf) {
  beat("a", "one", {});
  const PlaceRequest first = request();
  ASSERT_TRUE(sessions_.place(first));
  const auto field = [&](const std::string& name) {
    return client_->command({"HGET", "diaphane:worker:a", name})->text;
  };
  EXPECT_EQ(field("expected"), "0.4");
  EXPECT_EQ(field("sessions"), "0") << "not counted twice: its reservation is not in `expected`";
  beat("a", "one", {{first.session_id, "1"}});
  EXPECT_EQ(field("sessions"), "1");
}

TEST_F(HeartbeatTest, ASessionThatWasEndedOrMovedIsEndedByItsWorker) {
  beat("a", "one", {});
  const PlaceRequest ended = request(), moved = request();
  ASSERT_TRUE(sessions_.place(ended));
  ASSERT_TRUE(sessions_.place(moved));
  const HeartbeatTest::Live live{{ended.session_id, "1"}, {moved.session_id, "1"}};
  EXPECT_TRUE(beat("a", "one", live).empty());
  ASSERT_TRUE(sessions_.end(ended.session_id));
  ASSERT_TRUE(*sessions_.lost("a", "one"));
  beat("b", "one", {});
  ASSERT_EQ(sessions_.place(moved)->worker_id, "b");
  EXPECT_THAT(beat("a", "one", live),
              testing::UnorderedElementsAre(ended.session_id, moved.session_id));
  EXPECT_EQ(used("a"), 0);
}

TEST_F(HeartbeatTest, ARestartedWorkerHasNoSessions) {
  beat("a", "one", {});
  const PlaceRequest once = request();
  ASSERT_TRUE(sessions_.place(once));
  beat("a", "two", {});
  EXPECT_EQ(used("a"), 0);
  EXPECT_EQ(sessions_.place(once)->placement, 2u);
}

}  // namespace
}  // namespace diaphane::api::redis
