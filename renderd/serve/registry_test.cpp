#include "renderd/serve/registry.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/support/renderd/eventually.h"
#include "tests/support/renderd/test_redis.h"
#include "tests/support/renderd/test_worker.h"

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;

struct RegistryTest : testing::Test {
  RegistryTest() {
    options.volume_dir = store.path;
    worker = std::make_unique<RenderWorker>(options, std::make_unique<FakeEngine>(device), metrics,
                                            clock);
  }
  std::unique_ptr<Registry> announce(const std::string& incarnation = "first",
                                     const std::string& address = "127.0.0.1:8085",
                                     std::function<void(const std::string&)> name_taken = {}) {
    return std::make_unique<Registry>(
        Registry::Options{"w1", incarnation, address, "fake", "a test", "node-1",
                          [this] { return worker->homes().busy_seconds(); },
                          [this] { return worker->volumes().loaded(); }, std::move(name_taken)},
        redis.client(), worker->host(), metrics);
  }
  std::pair<Attachment, std::shared_ptr<Link>> attach(const std::string& session,
                                                      std::uint64_t placement = 1) {
    v1::Open open;
    open.set_viewer(v1::VIEWER_OWNER);
    open.set_session_id(session);
    open.set_volume_id(volume);
    open.set_placement(placement);
    auto link = std::make_shared<Link>();
    Attachment attachment = *worker->host().open(open, link);
    attachment.receive(hello_message().SerializeAsString());
    EXPECT_TRUE(link->inbox.next_of(v1::ServerMessage::kFrame));
    return {attachment, link};
  }
  // Acknowledges frames until one shows `input`.
  static bool shows(Attachment& attachment, Link& link, std::uint64_t input) {
    for (;;) {
      const auto message = link.inbox.next_of(v1::ServerMessage::kFrame);
      if (!message) return false;
      attachment.receive(ack_message(message->frame().seq()).SerializeAsString());
      if (message->frame().input_seq() == input) return true;
    }
  }
  void place(const std::string& session, const std::string& on, int placement) {
    redis.ask({"HSET", "diaphane:session:" + session, "user", "u", "worker", on, "placement",
               std::to_string(placement)});
  }

  TestRedis redis;
  TestStore store;
  std::string volume = store.add_ball();
  std::shared_ptr<FakeDevice> device = std::make_shared<FakeDevice>();
  prometheus::Registry prometheus_registry;
  Metrics metrics{prometheus_registry};
  SystemClock clock;
  RenderWorker::Options options;
  std::unique_ptr<RenderWorker> worker;
};

TEST_F(RegistryTest, RegistersAndDeregisters) {
  auto registry = announce();
  ASSERT_TRUE(
      eventually([&] { return redis.field("diaphane:worker:w1", "address") == "127.0.0.1:8085"; }));
  EXPECT_EQ(redis.field("diaphane:worker:w1", "incarnation"), "first");
  EXPECT_EQ(redis.field("diaphane:worker:w1", "engine"), "fake");
  EXPECT_EQ(redis.field("diaphane:worker:w1", "slots"), std::to_string(options.host.slots));
  EXPECT_EQ(redis.field("diaphane:worker:w1", "used"), "0");
  EXPECT_EQ(redis.field("diaphane:worker:w1", "draining"), "0");
  EXPECT_EQ(redis.field("diaphane:worker:w1", "epoch"), "1");
  EXPECT_EQ(redis.ask({"SMEMBERS", "diaphane:workers"}), std::vector<std::string>{"w1"});
  EXPECT_EQ(redis.ask({"HMGET", "diaphane:worker:w1", "node"}), std::vector<std::string>{"node-1"});
  const std::int64_t lives = redis.number({"PTTL", "diaphane:worker:w1"});
  EXPECT_GT(lives, 1500);
  EXPECT_LE(lives, 3000);
  registry.reset();
  EXPECT_EQ(redis.number({"EXISTS", "diaphane:worker:w1"}), 0);
  EXPECT_TRUE(redis.ask({"SMEMBERS", "diaphane:workers"}).empty());
}

TEST_F(RegistryTest, ReportsTheExpectedLoadOfItsSessions) {
  auto registry = announce();
  const auto expected = [&] { return redis.field("diaphane:worker:w1", "expected"); };
  ASSERT_TRUE(eventually([&] { return expected() == "0.0000"; }));
  const auto [attachment, link] = attach(new_id());
  // Little is known about a new session, so it counts about a slot's share. The fake device works
  // immediately.
  ASSERT_TRUE(eventually([&] { return std::atof(expected().c_str()) > 0; }));
  EXPECT_EQ(redis.field("diaphane:worker:w1", "sessions"), "1");
}

TEST_F(RegistryTest, ExpectedLoadExcludesLentCapacity) {
  const auto begin = std::chrono::steady_clock::now();
  const auto all = [begin] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  Registry::Options registry_options{"w1", "first", "127.0.0.1:8085", "fake", "a test"};
  registry_options.busy_seconds = all;
  registry_options.volumes = [] { return std::vector<std::string>{}; };
  // Never less than the device's busy time, whatever the time between the two calls.
  registry_options.lent_seconds = [all] { return 2 * all(); };
  const Registry registry(std::move(registry_options), redis.client(), worker->host(), metrics);
  ASSERT_TRUE(eventually([&] { return redis.field("diaphane:worker:w1", "load") == "1.000"; }));
  EXPECT_EQ(redis.field("diaphane:worker:w1", "expected"), "0.0000");
}

TEST_F(RegistryTest, KeepsItsRegistrationAlive) {
  auto registry = announce();
  ASSERT_TRUE(eventually([&] { return registry->connected(); }));
  for (int i = 0; i < 8; ++i) {
    std::this_thread::sleep_for(500ms);
    ASSERT_EQ(redis.number({"EXISTS", "diaphane:worker:w1"}), 1) << "expired after " << i;
  }
}

TEST_F(RegistryTest, CountsLiveSessionsAndFreesSlotsOfEndedOnes) {
  const std::string id = new_id();
  const std::string reserved = new_id();
  place(id, "w1", 1);
  redis.ask({"ZADD", "diaphane:worker:w1:sessions", "9999999999999", reserved});
  auto [attachment, link] = attach(id);
  auto registry = announce();
  ASSERT_TRUE(eventually([&] { return redis.field("diaphane:worker:w1", "used") == "2"; }));
  EXPECT_EQ(redis.field("diaphane:worker:w1", "volumes"), volume);
  worker->host().moved_away(id);  // ended in any way
  ASSERT_TRUE(eventually([&] { return redis.field("diaphane:worker:w1", "used") == "1"; }));
  EXPECT_EQ(redis.ask({"ZRANGE", "diaphane:worker:w1:sessions", "0", "-1"}),
            std::vector<std::string>{reserved})
      << "a pending reservation is kept";
}

TEST_F(RegistryTest, ClearsSessionsOfThePreviousProcess) {
  redis.ask({"HSET", "diaphane:worker:w1", "incarnation", "dead"});
  redis.ask({"ZADD", "diaphane:worker:w1:sessions", "9999999999999", new_id()});
  auto registry = announce("second");
  ASSERT_TRUE(
      eventually([&] { return redis.field("diaphane:worker:w1", "incarnation") == "second"; }));
  EXPECT_EQ(redis.field("diaphane:worker:w1", "used"), "0");
}

TEST_F(RegistryTest, RestartAtTheSameAddressTakesOverImmediately) {
  redis.ask({"HSET", "diaphane:worker:w1", "incarnation", "killed", "address", "127.0.0.1:8085"});
  const auto begin = std::chrono::steady_clock::now();
  auto registry = announce("second");
  ASSERT_TRUE(
      eventually([&] { return redis.field("diaphane:worker:w1", "incarnation") == "second"; }));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 2s);
}

TEST_F(RegistryTest, RefusesSecondWorkerWithTheSameNameWhileTheFirstLives) {
  const std::string id = new_id();
  place(id, "w1", 1);
  auto [attachment, link] = attach(id);
  auto first = announce("first", "127.0.0.1:8085");
  ASSERT_TRUE(eventually([&] { return redis.field("diaphane:worker:w1", "used") == "1"; }));

  std::atomic<int> refused{0};
  std::string holder;
  auto second = announce("second", "127.0.0.1:9999", [&](const std::string& address) {
    holder = address;
    ++refused;
  });
  bool flapped = false;
  const bool reported = eventually([&] {
    flapped = flapped || redis.field("diaphane:worker:w1", "incarnation") != "first" ||
              redis.number({"ZCARD", "diaphane:worker:w1:sessions"}) != 1;
    return refused > 0;
  });
  EXPECT_TRUE(reported);
  EXPECT_EQ(holder, "127.0.0.1:8085");
  EXPECT_FALSE(flapped);
  EXPECT_FALSE(second->connected()) << "it is not ready";

  first.reset();  // it leaves in order, so the name is free
  EXPECT_TRUE(
      eventually([&] { return redis.field("diaphane:worker:w1", "incarnation") == "second"; }));
  EXPECT_EQ(refused, 1);
}

TEST_F(RegistryTest, ReportsRenderTimeOncePerUser) {
  worker->host().gpu_time().add("a", 1.5);
  worker->host().gpu_time().add("b", 0.0204);
  redis.ask({"HSET", "diaphane:render_time", "a", "100"});
  auto registry = announce();
  EXPECT_TRUE(eventually([&] { return redis.field("diaphane:render_time", "a") == "1600"; }));
  EXPECT_TRUE(eventually([&] { return redis.field("diaphane:render_time", "b") == "20"; }));
  worker->host().gpu_time().add("b", 0.0008);  // plus the remaining 0.4 ms
  EXPECT_TRUE(eventually([&] { return redis.field("diaphane:render_time", "b") == "21"; }));
  EXPECT_EQ(redis.field("diaphane:render_time", "a"), "1600");
}

TEST_F(RegistryTest, OnlyTheOwningWorkerStoresTheLastScene) {
  const std::string id = new_id();
  place(id, "w1", 4);
  auto [attachment, link] = attach(id, 4);
  auto registry = announce();
  const std::string key = "diaphane:session:" + id;
  ASSERT_TRUE(eventually([&] { return !redis.field(key, "scene").empty(); }));
  v1::Scene scene;
  ASSERT_TRUE(scene.ParseFromString(redis.field(key, "scene")));
  const v1::Scene moved = turned(scene, 12);
  attachment.receive(scene_message(8, moved).SerializeAsString());
  ASSERT_TRUE(eventually([&] { return redis.field(key, "input_seq") == "8"; }));
  EXPECT_EQ(redis.field(key, "scene"), moved.SerializeAsString());
  EXPECT_EQ(redis.field(key, "width"), "64");

  // Placed again, on this or another worker: the old placement writes nothing.
  redis.ask({"HSET", key, "placement", "5"});
  attachment.receive(scene_message(9, turned(scene, 13)).SerializeAsString());
  std::this_thread::sleep_for(500ms);
  EXPECT_EQ(redis.field(key, "input_seq"), "8");
}

TEST_F(RegistryTest, EndsSessionThatWasPlacedElsewhere) {
  const std::string id = new_id();
  place(id, "w1", 1);
  auto [attachment, link] = attach(id);
  auto registry = announce();
  ASSERT_TRUE(eventually([&] { return redis.field("diaphane:worker:w1", "used") == "1"; }));
  place(id, "w2", 2);
  ASSERT_TRUE(eventually([&] { return worker->host().used() == 0; }));
  EXPECT_EQ(link->inbox.ended()->code, ErrorCode::kConflict);
}

TEST_F(RegistryTest, SessionsContinueWithoutRedisAndReportLater) {
  const std::string id = new_id();
  place(id, "w1", 1);
  auto [attachment, link] = attach(id);
  auto registry = announce();
  ASSERT_TRUE(eventually([&] { return registry->connected(); }));
  redis.stop();
  ASSERT_TRUE(eventually([&] { return !registry->connected(); }));
  const auto config = link->inbox.all().front().config();
  attachment.receive(scene_message(3, turned(config.scene(), 5)).SerializeAsString());
  EXPECT_TRUE(shows(attachment, *link, 3));

  redis.start();  // empty
  place(id, "w1", 1);
  EXPECT_TRUE(eventually([&] { return redis.field("diaphane:worker:w1", "used") == "1"; }));
  // What was written while the session's hash was missing is lost, but the next change is not.
  attachment.receive(scene_message(4, turned(config.scene(), 6)).SerializeAsString());
  EXPECT_TRUE(
      eventually([&] { return redis.field("diaphane:session:" + id, "input_seq") == "4"; }));
}

TEST_F(RegistryTest, RestoresItsSessionsInAnEmptyRedis) {
  const std::string id = new_id(), user = new_id(), link = std::string(64, 'a');
  v1::Open open;
  open.set_viewer(v1::VIEWER_OWNER);
  open.set_session_id(id);
  open.set_volume_id(volume);
  open.set_placement(3);
  open.set_guest_slices(true);
  open.set_user_id(user);
  auto owner = std::make_shared<Link>();
  Attachment attachment = *worker->host().open(open, owner);
  attachment.receive(hello_message().SerializeAsString());
  open.set_participant(new_id());
  open.set_link(link);
  auto guest = std::make_shared<Link>();
  Attachment follower = *worker->host().open(open, guest);
  follower.receive(hello_message().SerializeAsString());
  const auto config = owner->inbox.next_of(v1::ServerMessage::kConfig);
  ASSERT_TRUE(config);
  const v1::Scene scene = turned(config->config().scene(), 5);
  attachment.receive(scene_message(9, scene).SerializeAsString());
  auto registry = announce();

  const std::string key = "diaphane:session:" + id;
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(eventually([&] { return redis.field(key, "user") == user; }));
    EXPECT_EQ(redis.field(key, "data_set"), volume);
    EXPECT_EQ(redis.field(key, "worker"), "w1");
    EXPECT_EQ(redis.field(key, "incarnation"), "first");
    EXPECT_EQ(redis.field(key, "placement"), "3");
    EXPECT_EQ(redis.field(key, "scene"), scene.SerializeAsString());
    EXPECT_EQ(redis.field(key, "presenter"), "owner");
    EXPECT_EQ(redis.field(key, "guest_slices"), "1");
    EXPECT_EQ(redis.field(key, "visitor"), "") << "an account's session";
    EXPECT_EQ(redis.ask({"KEYS", "diaphane:link:*"}),
              std::vector<std::string>{"diaphane:link:" + link});
    EXPECT_EQ(redis.ask({"GET", "diaphane:link:" + link}), std::vector<std::string>{id});
    EXPECT_EQ(redis.ask({"ZRANGE", "diaphane:user:" + user + ":sessions", "0", "-1"}),
              std::vector<std::string>{id});
    redis.stop();
    redis.start();
  }
  // What was ended on purpose stays ended.
  ASSERT_TRUE(eventually([&] { return redis.field(key, "user") == user; }));
  redis.ask({"SET", key + ":ended", "1"});
  redis.ask({"DEL", key});
  EXPECT_EQ(owner->inbox.ended()->code, ErrorCode::kConflict);
  EXPECT_EQ(redis.field(key, "user"), "");
}

TEST_F(RegistryTest, ReportsADrainImmediately) {
  auto registry = announce();
  ASSERT_TRUE(eventually([&] { return registry->connected(); }));
  const auto start = std::chrono::steady_clock::now();
  registry->drain(2000ms);
  EXPECT_LT(std::chrono::steady_clock::now() - start, 1s);
  EXPECT_EQ(redis.field("diaphane:worker:w1", "draining"), "1");
}

TEST_F(RegistryTest, DrainMovesSessionsOnlyIfThereIsRoomElsewhere) {
  Registry::Options registry_options;
  registry_options.worker_id = "w1";
  registry_options.incarnation = "first";
  registry_options.address = "127.0.0.1:8085";
  registry_options.busy_seconds = [] { return 0.0; };
  registry_options.volumes = [] { return std::vector<std::string>(); };
  registry_options.owner = "skull/uid/2";
  registry_options.memory = [] { return 0.25; };
  registry_options.error = [] { return 1.5; };
  registry_options.drain_ordered = [this](std::size_t room) { worker->host().move_away(room); };
  Registry registry(registry_options, redis.client(), worker->host(), metrics);
  auto [attachment, link] = attach(new_id());
  const std::string key = "diaphane:worker:w1";
  ASSERT_TRUE(eventually([&] { return redis.field(key, "used") == "1"; }));
  ASSERT_TRUE(eventually([&] { return redis.field(key, "owner") == "skull/uid/2"; }));
  EXPECT_EQ(redis.field(key, "memory"), "0.250");
  EXPECT_EQ(redis.field(key, "error"), "1.5");
  EXPECT_TRUE(eventually([&] { return redis.field(key, "idle_since").empty(); }));

  // Meant for the previous pod.
  redis.ask({"SET", key + ":drain", "skull/uid/1"});
  const std::string seen = redis.field(key, "sampled");
  ASSERT_TRUE(eventually([&] { return redis.field(key, "sampled") != seen; }));
  EXPECT_EQ(redis.field(key, "draining"), "0");

  redis.ask({"SET", key + ":drain", "skull/uid/2"});
  ASSERT_TRUE(eventually([&] { return redis.field(key, "draining") == "1"; }));
  const std::string then = redis.field(key, "sampled");
  ASSERT_TRUE(eventually([&] { return redis.field(key, "sampled") != then; }));
  EXPECT_EQ(worker->host().used(), 1U);  // there is no other worker
  v1::Open open;
  open.set_viewer(v1::VIEWER_OWNER);
  open.set_session_id(new_id());
  open.set_volume_id(volume);
  EXPECT_FALSE(worker->host().open(open, std::make_shared<Link>()));

  redis.ask({"SADD", "diaphane:workers", "w2"});
  redis.ask({"HSET", "diaphane:worker:w2", "slots", "1", "draining", "0"});
  ASSERT_TRUE(eventually([&] { return worker->host().used() == 0; }));
  EXPECT_EQ(link->inbox.ended()->code, ErrorCode::kUnavailable);
  ASSERT_TRUE(eventually([&] { return !redis.field(key, "idle_since").empty(); }));
}

}  // namespace
}  // namespace diaphane::render
