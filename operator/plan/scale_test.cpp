// How many workers, and how fast.
#include "operator/plan/scale.h"

#include <gtest/gtest.h>

#include "tests/support/operator/test_world.h"

namespace diaphane::fleet {
namespace {

std::size_t created(const ClusterState& world) { return all<CreateWorker>(plan(world, 1)).size(); }

std::vector<DrainReason> drains(const ClusterState& world) {
  std::vector<DrainReason> reasons;
  for (const SetDrain& one : all<SetDrain>(plan(world, 1))) reasons.push_back(one.drain.reason);
  return reasons;
}

TEST(Scale, FollowsDemandWithinBounds) {
  FleetSpec spec;
  spec.sessions_per_worker = 4;
  spec.max_replicas = 5;
  Demand demand;
  demand.sampled = kNow;
  demand.last_used = kNow;
  const auto least = [&] { return desired_replicas(spec, &demand, 3, kNow).least; };
  EXPECT_EQ(least(), 1);  // one, without any demand
  demand.used = 3;
  EXPECT_EQ(least(), 1);
  demand.used = 4;  // before the last slot is taken
  EXPECT_EQ(least(), 2);
  demand.used = 2;
  demand.reserved = 2;
  EXPECT_EQ(least(), 2);
  demand.reserved = 0;
  demand.refused = 7;
  EXPECT_EQ(least(), 3);
  demand.refused = 0;
  spec.min_idle_slots = 8;
  EXPECT_EQ(least(), 3);
  demand.used = 100;
  EXPECT_EQ(least(), 5);
  spec.replicas = 2;
  EXPECT_EQ(least(), 2);
  spec.replicas = 9;
  EXPECT_EQ(least(), 5);
  spec.replicas.reset();
  demand.sampled = kNow - 11;  // old: neither up nor down
  EXPECT_EQ(least(), 3);
  EXPECT_EQ(desired_replicas(spec, nullptr, 3, kNow).most, 3);
  spec.min_replicas = 4;
  EXPECT_EQ(desired_replicas(spec, nullptr, 0, kNow).least, 4);
}

TEST(Scale, ScalesToZeroOnlyIfConfiguredAndAfterTheDelay) {
  FleetSpec spec;
  spec.min_idle_slots = 5;
  Demand demand;
  demand.sampled = kNow;
  demand.last_used = kNow - 299;
  EXPECT_EQ(desired_replicas(spec, &demand, 1, kNow).least, 1);
  spec.scale_to_zero_after = 300;
  EXPECT_EQ(desired_replicas(spec, &demand, 1, kNow).most, 1);
  demand.last_used -= 1;
  EXPECT_EQ(desired_replicas(spec, &demand, 1, kNow).most, 0);
  demand.refused = 1;  // a user is refused
  EXPECT_EQ(desired_replicas(spec, &demand, 0, kNow).least, 1);
}

TEST(Scale, RebuildsTokenBucketFromCreationTimes) {
  EXPECT_EQ(refill_tokens(2, {}, kNow).count, 2);
  EXPECT_EQ(refill_tokens(2, {kNow, kNow}, kNow).count, 0);
  EXPECT_EQ(refill_tokens(2, {kNow, kNow}, kNow).next, kNow + 0.5);
  EXPECT_EQ(refill_tokens(2, {kNow, kNow}, kNow + 0.5).count, 1);
  EXPECT_EQ(refill_tokens(2, {kNow, kNow}, kNow + 100).count, 2);
  EXPECT_EQ(refill_tokens(0.25, {kNow}, kNow + 1).next, kNow + 4);
  EXPECT_EQ(refill_tokens(2, {kNow + 50, kNow + 50}, kNow).count, 0);  // from another clock
  EXPECT_GT(refill_tokens(0, {kNow}, kNow).count, 1000);
}

TEST(Scale, RateLimitsCreationAndRequeuesInTime) {
  ClusterState world = test_world(8);
  world.fleets[0].spec.replicas = 16;
  world.fleets[0].spec.max_refill_per_second = 3;
  EXPECT_EQ(created(world), 3u);
  for (int i = 0; i < 3; ++i) add_worker(world, i, "a").created = world.now;
  const Plan waiting = plan(world, 1);
  EXPECT_TRUE(all<CreateWorker>(waiting).empty());
  ASSERT_TRUE(waiting.requeue_after.has_value());
  EXPECT_NEAR(*waiting.requeue_after, 1.0 / 3, 1e-9);
  world.now += *waiting.requeue_after;
  EXPECT_EQ(created(world), 1u);
}

TEST(Scale, NamesUseTheLowestFreeNumbers) {
  ClusterState world = test_world(4);
  world.fleets[0].spec.replicas = 4;
  add_running(world, 1, "a", 0);
  Pod foreign;
  foreign.name = "render-2";
  world.pods.push_back(foreign);
  const auto made = all<CreateWorker>(plan(world, 1));
  ASSERT_EQ(made.size(), 3u);
  EXPECT_EQ(made[0].name, "render-0");
  EXPECT_EQ(made[1].name, "render-3");
  EXPECT_EQ(made[2].name, "render-4");
}

TEST(Scale, ScalesDownOnlyIdleWorkersAfterTheIdleTime) {
  ClusterState world = test_world(2);
  add_running(world, 0, "a", 1);
  add_running(world, 1, "a", 0);
  add_running(world, 2, "b", 0);
  world.telemetry[0].idle_since = 0;  // from before its session
  world.telemetry[2].idle_since = world.now - 59;
  const auto drained = all<SetDrain>(plan(world, 1));
  ASSERT_EQ(drained.size(), 1u);
  EXPECT_EQ(drained[0].worker, "render-1");
  EXPECT_EQ(drained[0].drain, (Drain{DrainReason::kIdle, world.now}));
  world.now += 2;
  for (Telemetry& sample : world.telemetry) sample.sampled = world.now;
  world.demand[0].sampled = world.now;
  EXPECT_EQ(drains(world).size(), 2u);
  world.demand[0].sampled = world.now - 11;  // without known demand, no worker is drained
  EXPECT_TRUE(drains(world).empty());
}

TEST(Scale, AddsNoReplacementsWhileDemandIsStale) {
  ClusterState world = test_world(4);
  for (int i = 0; i < 3; ++i) add_running(world, i, std::string(1, char('a' + i)), 1);
  world.telemetry[0].sampled = world.now - 5;
  world.demand[0].sampled = world.now - 11;
  EXPECT_EQ(created(world), 0u);  // otherwise one more with each plan
}

TEST(Scale, KeepsSurplusWithinTheHysteresis) {
  ClusterState world = test_world(8);
  for (int i = 0; i < 12; ++i) add_running(world, i, std::string(1, char('a' + i / 2)), 0);
  world.demand[0].used = 43;  // with one more 11 workers; with a tenth more 13
  EXPECT_TRUE(drains(world).empty());
  world.demand[0].used = 38;
  EXPECT_EQ(drains(world).size(), 1u);
}

TEST(Scale, ReducingReplicasDrainsTheLeastBusy) {
  ClusterState world = test_world(2);
  add_running(world, 0, "a", 3);
  add_running(world, 1, "a", 1);
  add_running(world, 2, "b", 2);
  world.fleets[0].spec.replicas = 2;
  const auto drained = all<SetDrain>(plan(world, 1));
  ASSERT_EQ(drained.size(), 1u);
  EXPECT_EQ(drained[0].worker, "render-1");
  EXPECT_EQ(drained[0].drain.reason, DrainReason::kReplicas);
}

TEST(Scale, UpgradeCreatesNewWorkerBeforeDraining) {
  ClusterState world = test_world(2);
  world.fleets[0].spec.replicas = 2;
  add_running(world, 0, "a", 2);
  add_running(world, 1, "a", 1);
  world.fleets[0].spec.template_hash = "two";
  EXPECT_TRUE(drains(world).empty());
  auto made = all<CreateWorker>(plan(world, 1));
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(made[0].template_hash, "two");
  add_running(world, 2, "b", 0);
  world.workers[2].template_hash = "two";
  const auto drained = all<SetDrain>(plan(world, 1));
  ASSERT_EQ(drained.size(), 1u);
  EXPECT_EQ(drained[0].worker, "render-1");  // the one with fewer sessions
  EXPECT_EQ(drained[0].drain.reason, DrainReason::kUpgrade);
  world.workers[1].drain = drained[0].drain;
  EXPECT_TRUE(drains(world).empty());  // one after the other
  EXPECT_EQ(created(world), 1u);
}

TEST(Scale, UpgradeWithoutRoomDrainsOnlyIfOthersHaveTheSlots) {
  ClusterState world = test_world(1);
  world.fleets[0].spec.replicas = 2;
  add_running(world, 0, "a", 3);
  add_running(world, 1, "a", 2);
  world.fleets[0].spec.template_hash = "two";
  EXPECT_TRUE(drains(world).empty());  // five sessions, four slots
  world.demand[0].used = 4;
  world.telemetry[1].sessions = 1;
  EXPECT_EQ(drains(world).size(), 1u);
}

}  // namespace
}  // namespace diaphane::fleet
