// Which peers are asked to help, from what a real Redis knows about them.
#include "renderd/serve/capacity_broker.h"

#include <gtest/gtest.h>

#include <atomic>
#include <set>

#include "tests/support/renderd/test_redis.h"

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;

struct CapacityBrokerTest : testing::Test {
  /// A peer as its heartbeat leaves it, until the test ends it.
  void peer(const std::string& id, const std::vector<std::string>& fields = {}) {
    const std::string key = "diaphane:worker:" + id;
    std::vector<std::string> words{"HSET", key,        "address", address(id), "load",
                                   "0.1",  "draining", "0",       "epoch",     "1"};
    words.insert(words.end(), fields.begin(), fields.end());
    redis.ask(words);
    redis.ask({"PEXPIRE", key, "600000"});
    redis.ask({"SADD", "diaphane:workers", id});
  }
  static std::string address(const std::string& id) { return id + ".test:1"; }
  std::unique_ptr<CapacityBroker> start(GrpcAssistants* asked, const std::string& owner = "") {
    CapacityBroker::Options options;
    options.worker_id = "us";
    options.incarnation = "now";
    options.address = "us.test:1";
    options.owner = owner;
    options.node = "node-1";
    options.period = 20ms;
    options.rules.most = 2;
    options.rules.most_spare = spare_helpers;
    options.rules.rest = rest;
    // The whole device, in the test's own time.
    options.busy_seconds = [this] { return busy ? seconds() : 0.0; };
    options.lent_seconds = [this] { return lent ? seconds() : 0.0; };
    options.waiting = [this] { return waiting.load(); };
    options.volumes = [] { return std::vector<std::string>{"seen-here"}; };
    options.updated = [this](std::size_t) { ++updates; };
    return std::make_unique<CapacityBroker>(std::move(options), redis.client(), asked);
  }
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  std::set<std::string> borrowed() const {
    const auto all = helpers.borrowed();
    return {all.begin(), all.end()};
  }
  /// Whether `test` becomes true while the peers repeat their heartbeats.
  bool comes(const std::function<bool()>& test, const std::function<void()>& beat) {
    return eventually([&] {
      beat();
      return test();
    });
  }
  /// Waits for two more updates, whose decisions are then visible.
  void wait_for_two_updates() {
    const int before = updates;
    ASSERT_TRUE(eventually([&] { return updates >= before + 2; }));
  }

  TestRedis redis;
  const std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
  std::atomic<bool> busy{true}, lent{false};
  std::atomic<std::size_t> waiting{0};
  std::atomic<int> updates{0};
  std::size_t spare_helpers = 0;
  double rest = 3600;  ///< so that a slow machine does not look like an idle device
  GrpcAssistants helpers{{}, {}, 2};
};

TEST_F(CapacityBrokerTest, BorrowsWhileSeveralSessionsWaitAndReturnsAfterwards) {
  const auto beat = [&] { peer("a"); };
  beat();
  rest = 0.1;
  waiting = 1;
  const auto broker = start(&helpers);
  wait_for_two_updates();
  EXPECT_TRUE(borrowed().empty()) << "one session alone has the device";
  waiting = 3;
  EXPECT_TRUE(comes([&] { return borrowed() == std::set{address("a")}; }, beat));
  busy = false;
  waiting = 0;
  EXPECT_TRUE(comes([&] { return borrowed().empty(); }, beat));
}

TEST_F(CapacityBrokerTest, ReturnsHelperThatIsBusyDrainingOrDead) {
  waiting = 2;
  const auto broker = start(&helpers);
  const std::vector<std::vector<std::string>> changes{
      {"load", "0.97"}, {"draining", "1"}, {"asked", "0.95", "lent", "0.05"}};
  for (const auto& change : changes) {
    ASSERT_TRUE(comes([&] { return borrowed() == std::set{address("a")}; }, [&] { peer("a"); }));
    EXPECT_TRUE(comes([&] { return borrowed().empty(); }, [&] { peer("a", change); }))
        << change.front();
    redis.ask({"HDEL", "diaphane:worker:a", "asked", "lent"});
  }
  ASSERT_TRUE(comes([&] { return borrowed() == std::set{address("a")}; }, [&] { peer("a"); }));
  redis.ask({"DEL", "diaphane:worker:a"});
  EXPECT_TRUE(eventually([&] { return borrowed().empty(); }));
}

TEST_F(CapacityBrokerTest, KeepsHelperThatIsBusyOnlyWithOurWork) {
  waiting = 2;
  const auto broker = start(&helpers);
  const auto helps = [&] { peer("a", {"load", "1", "asked", "0.05", "lent", "0.95"}); };
  ASSERT_TRUE(comes([&] { return borrowed() == std::set{address("a")}; }, [&] { peer("a"); }));
  helps();
  for (int i = 0; i < 5; ++i) {
    helps();
    wait_for_two_updates();
    ASSERT_EQ(borrowed(), std::set{address("a")});
  }
}

TEST_F(CapacityBrokerTest, BorrowsOnlyOtherWorkersOfTheSameFleet) {
  waiting = 5;
  const auto beat = [&] {
    peer("us", {"owner", "ours/uid/1"});
    peer("ours", {"owner", "ours/other/1"});
    peer("others", {"owner", "others/uid/1"});
    peer("nobodys");
    peer("older", {"owner", "ours/old/1", "epoch", "0"});
  };
  beat();
  const auto broker = start(&helpers, "ours/uid/1");
  EXPECT_TRUE(comes([&] { return borrowed() == std::set{address("ours")}; }, beat));
  beat();
  wait_for_two_updates();
  EXPECT_EQ(borrowed(), std::set{address("ours")});
}

TEST_F(CapacityBrokerTest, BorrowsSpareTimeForASessionAloneAndMoreDuringOverload) {
  spare_helpers = 2;
  waiting = 1;
  const auto beat = [&] {
    peer("a");
    peer("b", {"load", "0.6"});
  };
  beat();
  const auto broker = start(&helpers);
  ASSERT_TRUE(comes([&] { return borrowed() == std::set{address("a")}; }, beat));
  beat();
  wait_for_two_updates();
  EXPECT_EQ(borrowed(), std::set{address("a")}) << "the other is not idle";
  waiting = 4;
  EXPECT_TRUE(comes([&] { return borrowed() == std::set({address("a"), address("b")}); }, beat));
}

TEST_F(CapacityBrokerTest, BorrowsNothingForWorkThatNoSessionWaitsFor) {
  spare_helpers = 2;
  const auto beat = [&] { peer("a"); };
  beat();
  const auto broker = start(&helpers);  // the device is busy, for example with thumbnails
  for (int i = 0; i < 5; ++i) {
    beat();
    wait_for_two_updates();
    ASSERT_TRUE(borrowed().empty());
  }
}

TEST_F(CapacityBrokerTest, ReportsAndClearsLentCapacity) {
  peer("us", {"incarnation", "now"});
  lent = true;
  const auto broker = start(nullptr);
  const auto beat = [&] { peer("us", {"incarnation", "now"}); };
  EXPECT_TRUE(comes([&] { return redis.field("diaphane:worker:us", "lent") == "1.000"; }, beat));
  EXPECT_EQ(redis.field("diaphane:worker:us", "asked"), "0.000");
  waiting = 1;
  EXPECT_TRUE(comes([&] { return redis.field("diaphane:worker:us", "asked") == "1.000"; }, beat))
      << "the broker runs";
  lent = false;
  EXPECT_TRUE(comes(
      [&] {
        return redis.number({"HEXISTS", "diaphane:worker:us", "lent"}) == 0;
      },
      beat));
}

TEST_F(CapacityBrokerTest, DoesNotReportForAnotherWorkerOfTheSameName) {
  const auto beat = [&] { peer("us", {"incarnation", "another"}); };
  beat();
  lent = true;
  const auto broker = start(nullptr);
  wait_for_two_updates();
  EXPECT_EQ(redis.number({"HEXISTS", "diaphane:worker:us", "lent"}), 0);
}

TEST_F(CapacityBrokerTest, ReturnsHelpersWithoutRedisAndBorrowsAgainLater) {
  waiting = 2;
  const auto broker = start(&helpers);
  const auto beat = [&] { peer("a"); };
  ASSERT_TRUE(comes([&] { return borrowed() == std::set{address("a")}; }, beat));
  redis.stop();
  EXPECT_TRUE(eventually([&] { return borrowed().empty(); }));
  redis.start();
  EXPECT_TRUE(comes([&] { return borrowed() == std::set{address("a")}; }, beat));
}

TEST_F(CapacityBrokerTest, SendsNothingToRedisWithoutNeed) {
  waiting = 1;
  const auto broker = start(&helpers);
  wait_for_two_updates();
  const std::string before = redis.ask({"INFO", "commandstats"}).front();
  EXPECT_EQ(before.find("cmdstat_evalsha"), std::string::npos) << before;
  waiting = 2;
  EXPECT_TRUE(eventually([&] {
    return redis.ask({"INFO", "commandstats"}).front().find("cmdstat_evalsha") != std::string::npos;
  }));
}

TEST(LoadOfPeer, TellsWhatMakesAPeerAGoodHelper) {
  directory::Peer peer{.id = "a", .load = 0.25, .lent = 0.5, .age_s = 1.5};
  peer.volumes = {"v1", "v2"};
  peer.node = "node-1";
  const auto near = load_of(peer, "node-1", {"v2"});
  EXPECT_TRUE(near.same_node && near.has_volume && !near.draining);
  EXPECT_EQ(near.id, "a");
  EXPECT_EQ(near.load + near.lent, 0.75);
  EXPECT_EQ(near.age, 1.5);
  const auto far = load_of(peer, "node-2", {"v3"});
  EXPECT_FALSE(far.same_node || far.has_volume);
  peer.node = "";  // an older worker
  EXPECT_FALSE(load_of(peer, "", {}).same_node);
}

}  // namespace
}  // namespace diaphane::render
