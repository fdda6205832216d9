#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "common/ids.h"
#include "directory/sessions.h"
#include "tests/support/directory/test_redis_server.h"

namespace diaphane::directory {

/// The state that a worker reports.
struct Worker {
  std::string id;
  int slots = 4;
  std::string volumes = "";
  std::string draining = "0";
  std::string epoch = "1";
  std::string incarnation = "first";
  std::string load = "0";
  std::string expected = "";  // empty means that the worker does not report it
};

/// Sessions on a real Redis, empty before each test.
class SessionsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { server_ = std::make_unique<TestRedisServer>(); }
  static void TearDownTestSuite() { server_.reset(); }

  SessionsTest() : client_(*Client::create({.address = server_->address()})), sessions_(*client_) {
    EXPECT_TRUE(client_->command({"FLUSHALL"}));
  }

  /// Writes the same fields as a worker's heartbeat.
  void announce(const Worker& w) {
    const std::string key = "diaphane:worker:" + w.id;
    const std::string slots = std::to_string(w.slots);
    const std::string address = w.id + ":8085";
    ASSERT_TRUE(client_->command({"SADD", "diaphane:workers", w.id}));
    ASSERT_TRUE(client_->command({"HSET", key, "address", address, "incarnation", w.incarnation,
                                  "slots", slots, "used", "0", "draining", w.draining, "volumes",
                                  w.volumes, "epoch", w.epoch, "load", w.load}));
    if (w.expected.empty()) return;
    const std::string live = std::to_string(used(w.id));
    ASSERT_TRUE(client_->command({"HSET", key, "expected", w.expected, "sessions", live}));
  }
  void vanish(const std::string& worker) {
    ASSERT_TRUE(client_->command({"DEL", "diaphane:worker:" + worker}));
  }
  std::int64_t used(const std::string& worker) {
    return client_->command({"ZCARD", "diaphane:worker:" + worker + ":sessions"})->integer;
  }
  void expire_entry(const std::string& worker, const std::string& session) {
    ASSERT_TRUE(
        client_->command({"ZADD", "diaphane:worker:" + worker + ":sessions", "1", session}));
  }
  PlaceRequest request(const std::string& user = new_id(), const std::string& data_set = new_id()) {
    return {new_id(), user, data_set};
  }

  static inline std::unique_ptr<TestRedisServer> server_;
  std::unique_ptr<Client> client_;
  Sessions sessions_;
};

}  // namespace diaphane::directory
