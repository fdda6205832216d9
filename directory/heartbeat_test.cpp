#include <gmock/gmock.h>

#include <utility>
#include <vector>

#include "directory/links.h"
#include "directory/worker.h"
#include "tests/support/directory/test_sessions.h"

namespace diaphane::directory {
namespace {

/// Runs a worker's heartbeat like renderd and returns the sessions that the worker must end.
class HeartbeatTest : public SessionsTest {
 protected:
  using Live = std::vector<std::pair<std::string, std::uint64_t>>;  // session id, placement
  std::vector<std::string> beat(const std::string& worker, const std::string& incarnation,
                                const Live& live) {
    Heartbeat heartbeat{.address = "host:1", .engine = "cpu", .device = "test", .slots = 2};
    heartbeat.load = 0.5;
    heartbeat.expected = 0.4;
    for (const auto& [id, placement] : live) heartbeat.sessions.push_back({id, placement});
    const auto reply = WorkerDirectory(*client_, worker, incarnation).beat(heartbeat);
    if (!reply) {
      ADD_FAILURE() << reply.error().message;
      return {};
    }
    return reply->ended;
  }
};

TEST_F(HeartbeatTest, HeartbeatHoldsTheSlotsOfLiveSessions) {
  beat("a", "one", {});
  const PlaceRequest first = request(), second = request();
  ASSERT_TRUE(sessions_.place(first));
  ASSERT_TRUE(sessions_.place(second));
  EXPECT_TRUE(beat("a", "one", {{first.session_id, 1}, {second.session_id, 1}}).empty());
  EXPECT_EQ(sessions_.place(request()).error().code, ErrorCode::kUnavailable);
  EXPECT_TRUE(beat("a", "one", {{first.session_id, 1}}).empty());
  EXPECT_TRUE(sessions_.place(request())) << "a session that the worker ended frees its slot";
}

TEST_F(HeartbeatTest, ExpectedLoadExcludesPendingReservations) {
  beat("a", "one", {});
  const PlaceRequest first = request();
  ASSERT_TRUE(sessions_.place(first));
  const auto field = [&](const std::string& name) {
    return client_->command({"HGET", "diaphane:worker:a", name})->text;
  };
  EXPECT_EQ(field("expected"), "0.4000");
  EXPECT_EQ(field("sessions"), "0") << "not counted twice: its reservation is not in `expected`";
  beat("a", "one", {{first.session_id, 1}});
  EXPECT_EQ(field("sessions"), "1");
}

TEST_F(HeartbeatTest, HeartbeatReplyListsEndedAndMovedSessions) {
  beat("a", "one", {});
  const PlaceRequest ended = request(), moved = request();
  ASSERT_TRUE(sessions_.place(ended));
  ASSERT_TRUE(sessions_.place(moved));
  const HeartbeatTest::Live live{{ended.session_id, 1}, {moved.session_id, 1}};
  EXPECT_TRUE(beat("a", "one", live).empty());
  ASSERT_TRUE(sessions_.end(ended.session_id));
  ASSERT_TRUE(*sessions_.lost("a", "one"));
  beat("b", "one", {});
  ASSERT_EQ(sessions_.place(moved)->worker_id, "b");
  EXPECT_THAT(beat("a", "one", live),
              testing::UnorderedElementsAre(ended.session_id, moved.session_id));
  EXPECT_EQ(used("a"), 0);
}

TEST_F(HeartbeatTest, RefusesSecondWorkerWithTheSameName) {
  beat("a", "one", {});
  WorkerDirectory second(*client_, "a", "two");
  const auto refused = second.beat({.address = "host:2", .slots = 2});
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->name_taken_by, "host:1");
  EXPECT_EQ(client_->command({"HGET", "diaphane:worker:a", "incarnation"})->text, "one");
  const auto taken_over = second.beat({.address = "host:1", .slots = 2});
  ASSERT_TRUE(taken_over);
  EXPECT_FALSE(taken_over->name_taken_by) << "the process before it had the same port";
}

TEST_F(HeartbeatTest, WorkerRestoresSessionLostByRedisOnce) {
  const std::string id = new_id();
  WorkerDirectory worker(*client_, "a", "one");
  Heartbeat heartbeat{.address = "host:1", .slots = 2};
  heartbeat.sessions = {{.id = id, .placement = 3, .visitor = true}};
  EXPECT_THAT(worker.beat(heartbeat)->unknown, testing::ElementsAre(id));
  EXPECT_EQ(client_->command({"ZCARD", "diaphane:visitors"})->integer, 1);
  LostSession lost{.id = id, .user_id = new_id(), .data_set_id = new_id()};
  lost.saved = {.placement = 3, .scene = "scene", .input_seq = 7, .width = 64, .height = 32};
  const std::string narrow(64, 'a'), wide(64, 'b');
  lost.links = {narrow, wide + " slices"};
  EXPECT_TRUE(*worker.restore(lost));
  EXPECT_FALSE(*worker.restore(lost));
  EXPECT_TRUE(worker.beat(heartbeat)->unknown.empty());
  EXPECT_EQ(sessions_.find(id)->worker_id, "a");
  Links links(*client_);
  EXPECT_EQ(links.follow(narrow)->session.id, id);
  EXPECT_FALSE(links.follow(narrow)->slices);
  EXPECT_TRUE(links.follow(wide)->slices) << "each link keeps its permission";
  lost.saved.input_seq = 8;
  EXPECT_TRUE(*worker.save_scene(id, lost.saved));
  EXPECT_EQ(client_->command({"HGET", "diaphane:session:" + id, "input_seq"})->text, "8");
  lost.saved.placement = 2;
  EXPECT_FALSE(*worker.save_scene(id, lost.saved)) << "it was placed again since";
}

TEST_F(HeartbeatTest, RestartedWorkerHasNoSessions) {
  beat("a", "one", {});
  const PlaceRequest once = request();
  ASSERT_TRUE(sessions_.place(once));
  beat("a", "two", {});
  EXPECT_EQ(used("a"), 0);
  EXPECT_EQ(sessions_.place(once)->placement, 2u);
}

}  // namespace
}  // namespace diaphane::directory
