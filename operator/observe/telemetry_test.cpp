#include "operator/observe/telemetry.h"

#include <gtest/gtest.h>

namespace diaphane::fleet {
namespace {

using directory::FleetPage;
using directory::WorkerReport;

/// One page with the demand of one fleet.
FleetPage page(const std::vector<WorkerReport>& workers = {}) {
  return {.next = "0", .demand = {{.refused = 2, .idle_s = 10}}, .workers = workers};
}

Reading read(const std::vector<FleetPage>& pages, Seconds now = 100) {
  TelemetryReader reader({"skull"});
  for (const FleetPage& one : pages) reader.add(one, now);
  return reader.take();
}

TEST(TelemetryOfRedis, TakesAgesNotTimesFromItsClock) {
  const Reading reading = read({page({{.owner = "skull/w/3",
                                       .age_s = 0.5,
                                       .busy = 0.25,
                                       .memory = 0.5,
                                       .sessions = 3,
                                       .used = 5,
                                       .slots = 16,
                                       .error = 1.5,
                                       .draining = true,
                                       .idle_s = 60}})});
  ASSERT_EQ(reading.telemetry.size(), 1U);
  const Telemetry& sample = reading.telemetry[0];
  EXPECT_EQ(sample.worker_uid, "w");
  EXPECT_EQ(sample.epoch, 3);
  EXPECT_EQ(sample.sampled, 99.5);
  EXPECT_EQ(sample.busy, 0.25);
  EXPECT_EQ(sample.memory, 0.5);
  EXPECT_EQ(sample.sessions, 3);
  EXPECT_EQ(sample.reserved, 2);
  EXPECT_EQ(sample.slots, 16);
  EXPECT_EQ(sample.error, 1.5);
  EXPECT_TRUE(sample.draining);
  EXPECT_EQ(sample.idle_since, 40);
  ASSERT_EQ(reading.demand.size(), 1U);
  EXPECT_EQ(reading.demand[0].used, 3);
  EXPECT_EQ(reading.demand[0].reserved, 2);
  EXPECT_EQ(reading.demand[0].refused, 2);
  EXPECT_EQ(reading.demand[0].last_used, 90);
}

TEST(TelemetryOfRedis, MergesPagesAndCountsEachWorkerOnce) {
  const WorkerReport of_v{.owner = "skull/v/1", .sessions = 1, .used = 1};
  const WorkerReport of_w{.owner = "skull/w/3", .sessions = 2, .used = 2};
  const WorkerReport before{.owner = "skull/w/2", .sessions = 4, .used = 4};
  TelemetryReader reader({"skull"});
  reader.add(page({of_v, of_w}), 100);
  reader.add(page(), 100);
  reader.add(page({of_w, before}), 101);
  const Reading reading = reader.take();
  EXPECT_EQ(reading.telemetry.size(), 3U);
  EXPECT_EQ(reading.demand[0].used, 1 + 2 + 4);
  EXPECT_EQ(reading.demand[0].refused, 2) << "each page says all";
  EXPECT_EQ(reading.demand[0].sampled, 101);
}

TEST(TelemetryOfRedis, SkipsWorkersWithoutAFleet) {
  for (const char* owner : {"", "x", "x/y", "/"}) {
    const Reading reading = read({page({{.owner = owner}, {.owner = "skull/w/3"}})});
    ASSERT_EQ(reading.telemetry.size(), 1U) << owner;
    EXPECT_EQ(reading.telemetry[0].worker_uid, "w");
  }
}

TEST(TelemetryCache, KeepsTheLastSampleOfSilentWorkers) {
  TelemetryCache cache;
  ClusterState world;
  world.workers.emplace_back().uid = "w";
  cache.note(read({page({{.owner = "skull/w/3", .sessions = 1}})}), 100);
  cache.note(read({page()}, 102), 102);
  world.now = 120;
  for (int again = 0; again < 2; ++again) {
    cache.fill(world);
    ASSERT_EQ(world.telemetry.size(), 1U);
    EXPECT_EQ(world.telemetry[0].sampled, 100);
    EXPECT_EQ(world.listening_since, 100);
    EXPECT_EQ(world.listened_until, 102);
    EXPECT_EQ(world.demand[0].sampled, 102);
  }
  world.workers.clear();
  cache.fill(world);
  EXPECT_TRUE(world.telemetry.empty());
}

TEST(TelemetryCache, RestartsListeningTimeAfterAGap) {
  TelemetryCache cache;
  const auto since = [&] {
    ClusterState world;
    cache.fill(world);
    return world.listening_since;
  };
  for (const Seconds now : {100, 101, 103}) cache.note({}, now);
  EXPECT_EQ(since(), 100);
  cache.missed();
  EXPECT_EQ(since(), 100);
  cache.note({}, 104);
  EXPECT_EQ(since(), 104);
  cache.note({}, 108);  // the operator itself was suspended
  EXPECT_EQ(since(), 108);
}

}  // namespace
}  // namespace diaphane::fleet
