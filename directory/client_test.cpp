#include "directory/client.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "tests/support/directory/test_redis_server.h"

namespace diaphane::directory {
namespace {

using std::chrono::milliseconds;

TEST(RedisClient, RefusesInvalidAddress) {
  for (const char* address : {"", "localhost", ":6379", "localhost:", "localhost:0",
                              "localhost:65536", "localhost:6379x"}) {
    EXPECT_EQ(Client::create({.address = address}).error().code, ErrorCode::kInvalid) << address;
  }
}

TEST(RedisClient, IsBinarySafe) {
  TestRedisServer server;
  auto client = Client::create({.address = server.address()});
  const std::string bytes("\0\r\n\xff$", 5);
  ASSERT_TRUE((*client)->command({"SET", "key", bytes}));
  EXPECT_EQ((*client)->command({"GET", "key"})->text, bytes);
}

TEST(RedisClient, LoadsScriptOnceAndThenRunsItByHash) {
  TestRedisServer server;
  auto client = Client::create({.address = server.address()});
  for (int i = 0; i < 2; ++i) {
    const Result<Reply> reply = (*client)->run(kListWorkers, {"1"});
    ASSERT_TRUE(reply) << reply.error().message;
    EXPECT_EQ(reply->kind, Reply::Kind::kList);
  }
  // The second call used the SHA-1. Otherwise, each call would send the source again.
  EXPECT_EQ((*client)->command({"SCRIPT", "EXISTS", kListWorkers.sha1})->list.at(0).integer, 1);
}

TEST(RedisClient, ReportsUnavailableAndReconnects) {
  TestRedisServer server;
  auto client = Client::create({.address = server.address()});
  ASSERT_TRUE((*client)->command({"SET", "key", "1"}));
  server.kill();
  EXPECT_EQ((*client)->command({"GET", "key"}).error().code, ErrorCode::kUnavailable);
  EXPECT_FALSE((*client)->answers(milliseconds(80)));
  server.start();
  EXPECT_EQ((*client)->command({"GET", "key"})->text, "1");
}

TEST(RedisClient, RetriesCommandOnDeadIdleConnection) {
  TestRedisServer server;
  auto client = Client::create({.address = server.address()});
  ASSERT_TRUE((*client)->command({"PING"}));
  server.kill();
  server.start();
  EXPECT_TRUE((*client)->command({"PING"}));
}

TEST(RedisClient, CommandTimesOutWhenRedisHangs) {
  TestRedisServer server;
  auto client = Client::create({.address = server.address(), .command_timeout = milliseconds(200)});
  ASSERT_TRUE((*client)->command({"PING"}));
  server.pause();
  EXPECT_EQ((*client)->command({"PING"}).error().code, ErrorCode::kUnavailable);
  EXPECT_FALSE((*client)->answers(milliseconds(80)));
  server.resume();
  EXPECT_TRUE((*client)->command({"PING"}));
}

TEST(RedisClient, ReadOnlyReplicaIsUnavailableAndCausesReconnect) {
  TestRedisServer server;
  auto client = Client::create({.address = server.address(), .connections = 1});
  const auto connection = [&] { return (*client)->command({"CLIENT", "ID"})->integer; };
  const auto first = connection();
  ASSERT_TRUE((*client)->run(kAddRenderTime, {"somebody", "1"}));
  ASSERT_TRUE((*client)->command({"REPLICAOF", "127.0.0.1", "1"}));
  EXPECT_EQ(connection(), first) << "reading from a replica is allowed";
  EXPECT_EQ((*client)->command({"SET", "key", "1"}).error().code, ErrorCode::kUnavailable);
  const auto second = connection();
  EXPECT_NE(second, first);
  EXPECT_EQ((*client)->run(kAddRenderTime, {"somebody", "1"}).error().code,
            ErrorCode::kUnavailable);
  EXPECT_NE(connection(), second);
  ASSERT_TRUE((*client)->command({"REPLICAOF", "NO", "ONE"}));
  EXPECT_TRUE((*client)->run(kAddRenderTime, {"somebody", "1"}));
}

TEST(RedisClient, RefusedCommandIsInternalErrorAndKeepsTheConnection) {
  TestRedisServer server;
  auto client = Client::create({.address = server.address(), .connections = 1});
  const auto before = (*client)->command({"CLIENT", "ID"})->integer;
  EXPECT_EQ((*client)->command({"NONSENSE"}).error().code, ErrorCode::kInternal);
  const Result<Reply> refused = (*client)->run(kAddRenderTime, {"somebody", "much"});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInternal);
  EXPECT_TRUE(refused.error().message.starts_with("Redis refused add_render_time.lua: "));
  EXPECT_EQ((*client)->command({"CLIENT", "ID"})->integer, before);
}

TEST(RedisClient, MoreThreadsThanConnectionsShareThem) {
  TestRedisServer server;
  auto client = Client::create({.address = server.address(), .connections = 2});
  std::atomic<int> answered = 0;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 8; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < 50; ++i)
          answered += (*client)->command({"INCR", "n"}).has_value() ? 1 : 0;
      });
    }
  }
  EXPECT_EQ(answered, 400);
  EXPECT_EQ((*client)->command({"GET", "n"})->text, "400");
  const std::string clients = (*client)->command({"CLIENT", "LIST"})->text;
  EXPECT_LE(std::count(clients.begin(), clients.end(), '\n'), 2);
}

}  // namespace
}  // namespace diaphane::directory
