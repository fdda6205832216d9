#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "common/ids.h"
#include "directory/fleets.h"
#include "directory/sessions.h"
#include "directory/worker.h"
#include "tests/support/directory/test_redis_server.h"

// Placement with many workers, and the demand that an operator reads.

namespace diaphane::directory {
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

TEST_F(FleetTest, BalancesSessionsOverHundredsOfWorkers) {
  constexpr int kWorkers = 150;
  for (int i = 0; i < kWorkers; ++i) announce("w" + std::to_string(i));
  std::map<std::string, int> taken;
  for (int i = 0; i < 2 * kWorkers; ++i) {
    const auto placed = sessions_.place(request());
    ASSERT_TRUE(placed) << placed.error().message;
    ++taken[placed->worker_id];
  }
  // On average, each has two. It does not happen that all 64 sampled workers have three already.
  for (const auto& [worker, count] : taken) EXPECT_LE(count, 3) << worker;
  for (int i = 2 * kWorkers; i < 4 * kWorkers; ++i) {
    // Some requests do not find one of the last slots, which is why the bound below is 98 %.
    if (const auto placed = sessions_.place(request())) ++taken[placed->worker_id];
  }
  int all = 0;
  for (const auto& [worker, count] : taken) {
    EXPECT_LE(count, 4) << worker;
    all += count;
  }
  EXPECT_GT(all, 4 * kWorkers * 98 / 100);
}

TEST_F(FleetTest, FindsWorkerWithTheVolumeAmongHundreds) {
  const std::string volume = new_id();
  for (int i = 0; i < 300; ++i) announce("w" + std::to_string(i));
  const auto first = sessions_.place(request(volume));
  ASSERT_TRUE(first);
  for (int i = 1; i <= 3; ++i) {
    announce(first->worker_id, volume, std::to_string(i));  // it has loaded it, and is at rest
    EXPECT_EQ(sessions_.place(request(volume))->worker_id, first->worker_id);
  }
  EXPECT_NE(sessions_.place(request(volume))->worker_id, first->worker_id) << "full";
}

TEST_F(FleetTest, ReadsThousandsOfWorkersInPages) {
  constexpr std::size_t kWorkers = 1000;
  for (std::size_t i = 0; i < kWorkers; ++i) {
    const std::string id = "w" + std::to_string(i);
    announce(id);
    ASSERT_TRUE(client_->command({"HSET", "diaphane:worker:" + id, "owner", "skull/" + id + "/1"}));
  }
  std::set<std::string> owners;
  std::string cursor(kFirstPage);
  std::size_t pages = 0, longest = 0;
  do {
    const auto page = read_fleets(*client_, cursor, {"skull"}, {});
    ASSERT_TRUE(page) << page.error().message;
    cursor = page->next;
    for (const WorkerReport& one : page->workers) owners.insert(one.owner);
    longest = std::max(longest, page->workers.size());
    ++pages;
  } while (cursor != kFirstPage && pages < kWorkers);
  EXPECT_EQ(owners.size(), kWorkers);
  EXPECT_GE(pages, 3U);
  EXPECT_LE(longest, kWorkers / 2) << "who asks for a place waits for so many";
}

TEST_F(FleetTest, ReadsReportAndDeliversDrainRequestOnlyToItsWorker) {
  WorkerDirectory worker(*client_, "w", "first"), other(*client_, "other", "first");
  const Heartbeat heartbeat{
      .address = "host:1", .slots = 4, .load = 0.25, .sessions = {{.id = new_id()}}};
  const FleetReport report{.owner = "skull/uid/2", .memory = 0.5, .error = 1.5};
  ASSERT_TRUE(worker.beat(heartbeat));
  EXPECT_EQ(*worker.report(report), std::nullopt);
  const auto read = [&](const std::vector<DrainRequest>& draining) {
    const auto page = read_fleets(*client_, kFirstPage, {"skull"}, draining);
    return page && page->workers.size() == 1 ? page->workers[0] : WorkerReport();
  };
  const WorkerReport seen = read({{"w", "skull/uid/1"}});
  EXPECT_EQ(seen.owner, "skull/uid/2");
  EXPECT_EQ(seen.busy, 0.25);
  EXPECT_EQ(seen.memory, 0.5);
  EXPECT_EQ(seen.error, 1.5);
  EXPECT_EQ(seen.sessions, 1);
  EXPECT_EQ(seen.used, 1);
  EXPECT_EQ(seen.slots, 4);
  EXPECT_FALSE(seen.draining);
  EXPECT_LT(seen.age_s, 2);
  EXPECT_EQ(*worker.report(report), std::nullopt) << "the request is for the pod before this one";
  (void)read({{"w", "skull/uid/2"}});
  EXPECT_EQ(*worker.report(report), 0U) << "no room elsewhere";
  EXPECT_TRUE(read({}).draining);
  ASSERT_TRUE(other.beat({.address = "host:2", .slots = 3}));
  EXPECT_EQ(*worker.report(report), 3U);
}

TEST_F(FleetTest, ClampsInvalidFieldsOfAWorker) {
  announce("w");
  ASSERT_TRUE(client_->command({"HSET", "diaphane:worker:w", "owner", "skull/w/x", "sampled", "nan",
                                "used", "1e300", "slots", "-1", "draining", "2"}));
  const auto page = read_fleets(*client_, kFirstPage, {"skull"}, {});
  ASSERT_TRUE(page) << page.error().message;
  ASSERT_EQ(page->workers.size(), 1U);
  EXPECT_EQ(page->workers[0].slots, 0);
  EXPECT_EQ(page->workers[0].used, 1'000'000'000);
  EXPECT_EQ(page->workers[0].sessions, 0);
  EXPECT_FALSE(page->workers[0].draining);
}

TEST_F(FleetTest, CountsEachRefusedSessionOnceInOneFleet) {
  Sessions skull(*client_, {}, "skull");
  const auto asked = request();
  EXPECT_FALSE(skull.place(asked));
  EXPECT_FALSE(skull.place(asked));
  EXPECT_FALSE(skull.place(request()));
  const auto refused = [&] {
    const auto page = read_fleets(*client_, kFirstPage, {"heart", "skull"}, {});
    return std::vector<int>{page->demand[0].refused, page->demand[1].refused};
  };
  EXPECT_EQ(refused(), (std::vector<int>{0, 2}));
  EXPECT_FALSE(sessions_.place(request())) << "of an api that names no fleet";
  EXPECT_EQ(refused(), (std::vector<int>{1, 2}));
}

}  // namespace
}  // namespace diaphane::directory
