#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>

#include "api/redis/sessions.h"
#include "api/redis/test_redis_server.h"
#include "common/ids.h"

// Placing with many workers, and what an operator learns of who found no place.

namespace diaphane::api::redis {
namespace {

class FleetTest : public testing::Test {
 protected:
  void announce(const std::string& id, const std::string& volumes = "",
                const std::string& sessions = "0") {
    ASSERT_TRUE(client_->command({"SADD", "diaphane:workers", id}));
    ASSERT_TRUE(client_->command({"HSET",        "diaphane:worker:" + id,
                                  "address",     "host:1",
                                  "incarnation", "i",
                                  "slots",       "4",
                                  "used",        "0",
                                  "draining",    "0",
                                  "volumes",     volumes,
                                  "epoch",       "1",
                                  "load",        "0",
                                  "expected",    "0",
                                  "sessions",    sessions}));
  }
  static PlaceRequest request(const std::string& data_set = new_id()) {
    return {new_id(), new_id(), data_set};
  }

  TestRedisServer server_;
  std::unique_ptr<Client> client_ = *Client::create({.address = server_.address()});
  Sessions sessions_{*client_};
};

TEST_F(FleetTest, OfHundredsOfWorkersNoneGetsMuchMoreThanAnother) {
  constexpr int kWorkers = 150;
  for (int i = 0; i < kWorkers; ++i) announce("w" + std::to_string(i));
  std::map<std::string, int> taken;
  for (int i = 0; i < 2 * kWorkers; ++i) {
    const auto placed = sessions_.place(request());
    ASSERT_TRUE(placed) << placed.error().message;
    ++taken[placed->worker_id];
  }
  // Two each on average: that all 64 that are looked at have three already does not happen.
  for (const auto& [worker, count] : taken) EXPECT_LE(count, 3) << worker;
  for (int i = 2 * kWorkers; i < 4 * kWorkers; ++i) {
    // The last slots are not found by all: they are asked for again.
    if (const auto placed = sessions_.place(request())) ++taken[placed->worker_id];
  }
  int all = 0;
  for (const auto& [worker, count] : taken) {
    EXPECT_LE(count, 4) << worker;
    all += count;
  }
  EXPECT_GT(all, 4 * kWorkers * 98 / 100);
}

TEST_F(FleetTest, OfHundredsOfWorkersTheOneThatHasTheVolumeIsFound) {
  const std::string volume = new_id();
  for (int i = 0; i < 300; ++i) announce("w" + std::to_string(i));
  const auto first = sessions_.place(request(volume));
  ASSERT_TRUE(first);
  for (int i = 1; i <= 3; ++i) {
    announce(first->worker_id, volume, std::to_string(i));  // it has loaded it, and they rest
    EXPECT_EQ(sessions_.place(request(volume))->worker_id, first->worker_id);
  }
  EXPECT_NE(sessions_.place(request(volume))->worker_id, first->worker_id) << "full";
}

/// operator/observe/fleets.lua as text.
std::string fleets_script() {
  std::ifstream file(FLEETS_LUA);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST_F(FleetTest, ThousandsOfWorkersAreReadPageByPage) {
  constexpr std::size_t kWorkers = 1000;
  for (std::size_t i = 0; i < kWorkers; ++i) {
    const std::string id = "w" + std::to_string(i);
    announce(id);
    ASSERT_TRUE(client_->command({"HSET", "diaphane:worker:" + id, "owner", "skull/" + id + "/1"}));
  }
  const std::string script = fleets_script();
  std::set<std::string> owners;
  std::string cursor = "0";
  std::size_t pages = 0, longest = 0;
  do {
    const auto reply = client_->command({"EVAL", script, "0", cursor, "1", "skull"});
    ASSERT_TRUE(reply) << reply.error().message;
    cursor = reply->at(0);
    std::istringstream lines(reply->at(4));
    std::size_t count = 0;
    for (std::string line; std::getline(lines, line); ++count) {
      owners.insert(line.substr(0, line.find(' ')));
    }
    longest = std::max(longest, count);
    ++pages;
  } while (cursor != "0" && pages < kWorkers);
  EXPECT_EQ(owners.size(), kWorkers);
  EXPECT_GE(pages, 3U);
  EXPECT_LE(longest, kWorkers / 2) << "who asks for a place waits for so many";
}

TEST_F(FleetTest, WhoFindsNoPlaceIsCountedByOneFleet) {
  Sessions skull(*client_, {}, "skull");
  const auto asked = request();
  EXPECT_FALSE(skull.place(asked));
  EXPECT_FALSE(skull.place(asked));
  EXPECT_FALSE(skull.place(request()));
  const std::string source = fleets_script();
  const auto refused = [&] {
    const auto reply = client_->command({"EVAL", source, "0", "0", "2", "heart", "skull"});
    return reply->list[2].at(0) + " " + reply->list[2].at(1);
  };
  EXPECT_EQ(refused(), "0 2");
  EXPECT_FALSE(sessions_.place(request())) << "of an api that names no fleet";
  EXPECT_EQ(refused(), "1 2");
}

}  // namespace
}  // namespace diaphane::api::redis
