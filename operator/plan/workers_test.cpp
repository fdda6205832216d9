// The life of one worker, and each row of "When things fail" that is a decision of the plan.
#include <gtest/gtest.h>

#include "operator/plan/parts.h"
#include "tests/support/operator/test_world.h"

namespace diaphane::fleet {
namespace {

/// A fleet with one worker on node a, whose pod runs.
ClusterState one_running(int sessions = 0) {
  ClusterState world = test_world(2);
  world.fleets[0].spec.replicas = 1;
  add_running(world, 0, "a", sessions);
  return world;
}

/// Writes statuses as they are after `seconds` without a change.
void settle(ClusterState& world, Seconds seconds = 0) {
  for (const SetWorkerStatus& one : all<SetWorkerStatus>(plan(world, 1))) {
    for (Worker& worker : world.workers) {
      if (worker.uid == one.uid) worker.status = one.status;
    }
  }
  for (const SetFleetStatus& one : all<SetFleetStatus>(plan(world, 1))) {
    world.fleets[0].status = one.status;
  }
  world.now += seconds;
  world.listened_until = world.now;
  for (Demand& demand : world.demand) demand.sampled = world.now;
}

void beat(ClusterState& world) {
  for (Telemetry& sample : world.telemetry) sample.sampled = world.now;
}

std::optional<DrainReason> drained(const ClusterState& world) {
  const auto found = all<SetDrain>(plan(world, 1));
  if (found.empty()) return std::nullopt;
  return found.front().drain.reason;
}

ConditionStatus says(const ClusterState& world, const char* type) {
  ClusterState copy = world;
  settle(copy);
  const Condition* is = find(copy.workers[0].status.conditions, type);
  return is ? is->status : ConditionStatus::kUnknown;
}

TEST(Workers, CreatesReservationThenPodThenNothing) {
  ClusterState world = test_world(1);
  world.fleets[0].spec.replicas = 1;
  Plan next = plan(world, 1);
  EXPECT_EQ(deeds(next), 1u);
  EXPECT_EQ(all<CreateWorker>(next).size(), 1u);
  add_worker(world, 0, "a").status.epoch = 0;
  next = plan(world, 1);
  EXPECT_EQ(deeds(next), 1u);
  EXPECT_EQ(all<CreatePod>(next), (std::vector<CreatePod>{{"render-0", "uid-0", "a", "one", 1}}));
  world.workers[0].status.epoch = 1;
  const Worker worker = world.workers[0];
  add_pod(world, worker);
  add_sample(world, worker, 0);
  settle(world);
  next = plan(world, 1);
  EXPECT_TRUE(next.actions.empty());
  EXPECT_TRUE(next.requeue_after.has_value());
}

TEST(Workers, PlansNothingBeforeEverythingWasListed) {
  ClusterState world = test_world(2);
  world.fleets[0].spec.replicas = 2;
  world.complete = false;
  EXPECT_TRUE(plan(world, 1).actions.empty());
}

TEST(Workers, EvaluatesAgainSoonWhileThereIsAFleetOrAWorker) {
  ClusterState fleet_alone = test_world(1);
  fleet_alone.fleets[0].spec.replicas = 0;
  EXPECT_LE(plan(fleet_alone, 1).requeue_after.value_or(1e9), 3);
  ClusterState worker_alone = one_running();
  worker_alone.fleets.clear();
  EXPECT_LE(plan(worker_alone, 1).requeue_after.value_or(1e9), 3);
  ClusterState nothing;
  nothing.complete = true;
  EXPECT_FALSE(plan(nothing, 1).requeue_after.has_value());
}

// pod crash
TEST(WhenThingsFail, CountsFailedPodAndRecreatesItAfterBackoff) {
  ClusterState world = one_running();
  world.telemetry.clear();
  world.pods[0].phase = Phase::kFailed;
  EXPECT_EQ(deeds(plan(world, 1)), 0u);  // counted first
  settle(world);
  EXPECT_EQ(world.workers[0].status.failures, 1);
  settle(world);
  EXPECT_EQ(world.workers[0].status.failures, 1);  // once
  EXPECT_EQ(all<DeletePod>(plan(world, 1)), (std::vector<DeletePod>{{"render-0", "pod-of-uid-0"}}));
  world.pods.clear();
  EXPECT_TRUE(all<CreatePod>(plan(world, 1)).empty());
  EXPECT_NEAR(plan(world, 1).requeue_after.value(), 1, 1e-9);
  world.now += 1;
  const auto made = all<CreatePod>(plan(world, 1));
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(made[0].epoch, 2);
  EXPECT_EQ(made[0].node, "a");  // its reservation
}

TEST(WhenThingsFail, GivesUpRepeatedlyFailingPodAndAvoidsItsNode) {
  ClusterState world = one_running();
  world.telemetry.clear();
  world.pods[0].phase = Phase::kFailed;
  world.workers[0].status.failures = kMostFailures;
  world.workers[0].status.failed_pod = world.pods[0].uid;
  EXPECT_EQ(drained(world), std::nullopt);  // its refusal is recorded first
  settle(world);
  ASSERT_EQ(world.fleets[0].status.refusals.size(), 1u);
  EXPECT_EQ(world.fleets[0].status.refusals[0].node, "a");
  EXPECT_EQ(drained(world), DrainReason::kFailing);
  const auto other = all<CreateWorker>(plan(world, 1));
  ASSERT_EQ(other.size(), 1u);
  EXPECT_EQ(other[0].node, "b");
}

TEST(WhenThingsFail, ResetsFailuresAfterTwoMinutes) {
  ClusterState world = one_running();
  world.workers[0].status.failures = 2;
  world.workers[0].status.failed_at = world.now - 119;
  settle(world);
  EXPECT_EQ(world.workers[0].status.failures, 2);
  settle(world, 2);
  beat(world);
  settle(world);
  EXPECT_EQ(world.workers[0].status.failures, 0);
}

// node lost
TEST(WhenThingsFail, ReplacesWorkerOfLostNodeAndHoldsItsReservation) {
  ClusterState world = one_running(1);
  world.nodes[0].ready = false;
  world.now += 2;
  EXPECT_EQ(deeds(plan(world, 1)), 0u);  // its heartbeat is two seconds old
  world.now += 2;
  world.demand[0].sampled = world.now;
  EXPECT_EQ(says(world, "NodeLost"), ConditionStatus::kTrue);
  Plan next = plan(world, 1);
  EXPECT_EQ(deeds(next), 1u);
  ASSERT_EQ(all<CreateWorker>(next).size(), 1u);
  EXPECT_EQ(all<CreateWorker>(next)[0].node, "b");
  // When it is marked by hand or deleted, it drains without waiting for its sessions.
  for (const bool deleted : {false, true}) {
    ClusterState gone = world;
    add_running(gone, 1, "b", 0);
    settle(gone, 6);
    beat(gone);
    gone.telemetry[0].sampled -= 20;
    if (deleted) {
      gone.nodes.erase(gone.nodes.begin());
    } else {
      gone.nodes[0].taints.push_back({"node.kubernetes.io/out-of-service", "", "NoExecute"});
    }
    EXPECT_EQ(drained(gone), DrainReason::kNodeLost);
    gone.workers[0].drain = Drain{DrainReason::kNodeLost, gone.now};
    EXPECT_EQ(all<DeleteWorker>(plan(gone, 1)).size(), 1u);
    gone.workers[0].deleted = gone.now;
    EXPECT_EQ(all<DeletePod>(plan(gone, 1)).size(), 1u);
    EXPECT_TRUE(all<RemoveFinalizer>(plan(gone, 1)).empty());
    gone.pods.erase(gone.pods.begin());
    EXPECT_TRUE(all<RemoveFinalizer>(plan(gone, 1)).empty());
    settle(gone, kConfirmed);
    EXPECT_EQ(all<RemoveFinalizer>(plan(gone, 1)).size(), 1u);
  }
}

// one odd read
TEST(WhenThingsFail, SingleBadReadingEndsNoWorker) {
  void (*const odd[])(ClusterState&) = {
      [](ClusterState& w) { w.nodes.clear(); },
      [](ClusterState& w) { w.nodes[0].ready = false; },
      [](ClusterState& w) { w.pods.clear(); },
      [](ClusterState& w) { w.pods[0].ready = false; },
      [](ClusterState& w) { w.pods[0].phase = Phase::kUnknown; },
      [](ClusterState& w) { w.telemetry.clear(); },
      [](ClusterState& w) { w.telemetry[0].busy = std::numeric_limits<double>::quiet_NaN(); },
      [](ClusterState& w) { w.telemetry[0].epoch = 77; },
      [](ClusterState& w) { w.demand.clear(); },
  };
  for (std::size_t i = 0; i < std::size(odd); ++i) {
    ClusterState world = one_running(1);
    settle(world);
    odd[i](world);
    const Plan next = plan(world, 1);
    EXPECT_TRUE(all<SetDrain>(next).empty()) << i;
    EXPECT_TRUE(all<DeleteWorker>(next).empty()) << i;
    EXPECT_TRUE(all<DeletePod>(next).empty()) << i;
    EXPECT_TRUE(all<RemoveFinalizer>(next).empty()) << i;
  }
  ClusterState fleetless = one_running(1);
  fleetless.fleets.clear();
  EXPECT_EQ(deeds(plan(fleetless, 1)), 0u);
}

TEST(WhenThingsFail, ReplacesSilentWorkerAndDrainsItAfterAMinute) {
  ClusterState world = one_running(1);
  add_running(world, 1, "b", 0);
  world.fleets[0].spec.replicas = 2;
  world.telemetry[0].sampled = world.now - 4;
  EXPECT_EQ(says(world, "Unhealthy"), ConditionStatus::kTrue);
  EXPECT_EQ(drained(world), std::nullopt);
  EXPECT_EQ(all<CreateWorker>(plan(world, 1)).size(), 1u);
  world.telemetry[0].sampled = world.now - 61;
  EXPECT_EQ(drained(world), DrainReason::kUnhealthy);
}

TEST(WhenThingsFail, FleetSaysWhetherItIsDegraded) {
  ClusterState world = one_running();
  const auto reason = [](ClusterState settled) {
    settle(settled);
    const Condition* degraded = find(settled.fleets[0].status.conditions, "Degraded");
    return degraded ? degraded->reason : "no condition";
  };
  EXPECT_EQ(reason(world), "AsExpected");
  world.workers[0].status.failures = 1;
  world.workers[0].status.failed_at = world.now;
  EXPECT_EQ(reason(world), "WorkersFailing");
}

TEST(WhenThingsFail, WorkerSaysWhichGenerationWasObserved) {
  ClusterState world = one_running();
  world.workers[0].generation = 7;
  settle(world);
  EXPECT_EQ(world.workers[0].status.observed_generation, 7);
}

// Redis down
TEST(WhenThingsFail, TrustsKubernetesWhenAllWorkersAreSilent) {
  ClusterState world = test_world(4);
  for (int i = 0; i < 4; ++i) add_running(world, i, std::string(1, char('a' + i)), 0);
  settle(world, 300);
  world.demand[0].sampled -= 300;
  EXPECT_EQ(deeds(plan(world, 1)), 0u);
  settle(world);
  const Condition* fresh = find(world.fleets[0].status.conditions, "MetricsFresh");
  ASSERT_TRUE(fresh);
  EXPECT_EQ(fresh->status, ConditionStatus::kFalse);
}

TEST(WhenThingsFail, KeepsKnownWorkersWhileRedisIsUnavailable) {
  ClusterState world = test_world(2);
  for (int i = 0; i < 2; ++i) add_running(world, i, std::string(1, char('a' + i)), 1);
  world.fleets[0].spec.replicas = 2;
  // Their pods are too new to judge whether many are silent.
  for (Pod& pod : world.pods) pod.created = kNow - 5;
  settle(world, 0);
  for (const Seconds away : {4.0, 9.0, 30.0, 300.0}) {
    world.now = kNow + away;
    EXPECT_EQ(deeds(plan(world, 1)), 0u) << away;
  }
  // Redis is back and empty, so workers get time to reconnect. One that does not was known before.
  world.listening_since = world.listened_until = world.now;
  EXPECT_EQ(deeds(plan(world, 1)), 0u);
  world.now = world.listened_until += 9;
  world.telemetry[0].sampled = world.now - 1;
  EXPECT_EQ(deeds(plan(world, 1)), 0u);
  world.now = world.listened_until += 2;
  world.telemetry[0].sampled = world.now - 1;
  EXPECT_EQ(all<CreateWorker>(plan(world, 1)).size(), 1u);
}

// leader lost
TEST(WhenThingsFail, NextLeaderRecoversReservationsFromWorkers) {
  ClusterState world = test_world(1);
  world.fleets[0].spec.replicas = 2;
  add_worker(world, 0, "a");
  add_worker(world, 1, "a");  // the previous leader died before it created their pods
  world.telemetry.clear();
  world.listening_since = world.now;
  const Plan next = plan(world, 99);
  EXPECT_TRUE(all<CreateWorker>(next).empty());
  EXPECT_EQ(all<CreatePod>(next).size(), 2u);
}

// replayed events
TEST(WhenThingsFail, IgnoresTelemetryOfAnEarlierPod) {
  ClusterState world = one_running();
  world.workers[0].drain = Drain{DrainReason::kIdle, world.now - 5};
  world.telemetry[0].draining = true;
  EXPECT_EQ(all<DeleteWorker>(plan(world, 1)).size(), 1u);
  world.pods[0].epoch = 2;
  EXPECT_TRUE(all<DeleteWorker>(plan(world, 1)).empty());
  world.pods[0].epoch = 1;
  world.pods[0].created = world.now;  // with the same number, but created later
  EXPECT_TRUE(all<DeleteWorker>(plan(world, 1)).empty());
}

TEST(WhenThingsFail, UnschedulablePodMovesToTheNextNodeWithBackoff) {
  ClusterState world = one_running();
  world.telemetry.clear();
  world.pods[0].phase = Phase::kPending;
  world.pods[0].node.clear();
  world.pods[0].ready = false;
  world.pods[0].unschedulable = world.now - 1;
  EXPECT_EQ(deeds(plan(world, 1)), 0u);
  settle(world);
  ASSERT_EQ(world.fleets[0].status.refusals.size(), 1u);
  EXPECT_EQ(all<DeleteWorker>(plan(world, 1)).size(), 1u);
  ClusterState two = world;  // refused at the same time: one refusal
  add_worker(two, 1, "a");
  const Worker second = two.workers[1];
  Pod refused = two.pods[0];
  refused.name = second.name;
  refused.uid = "second";
  refused.owner_uid = second.uid;
  two.pods.push_back(refused);
  settle(two);
  EXPECT_EQ(two.fleets[0].status.refusals, world.fleets[0].status.refusals);
  EXPECT_EQ(all<DeleteWorker>(plan(two, 1)).size(), 2u);
  two.workers[1].created = two.now + 1;  // after the pause: a second
  EXPECT_EQ(refusals_of(build_view(two).fleets[0], two.now + 6)[0].count, 2);
  world.workers[0].deleted = world.now;
  const auto next = all<CreateWorker>(plan(world, 1));
  ASSERT_EQ(next.size(), 1u);
  EXPECT_EQ(next[0].node, "b");
}

TEST(WhenThingsFail, IgnoresForeignPods) {
  ClusterState world = one_running();
  Pod foreign;
  foreign.name = "render-7";
  foreign.labelled = false;
  foreign.phase = Phase::kFailed;
  world.pods.push_back(foreign);
  settle(world);
  EXPECT_TRUE(plan(world, 1).actions.empty());
  // A foreign pod is in the way, so another name is used.
  world.pods.clear();
  world.telemetry.clear();
  foreign.name = "render-0";
  foreign.uid = "theirs";
  world.pods.push_back(foreign);
  const Plan next = plan(world, 1);
  EXPECT_TRUE(all<DeletePod>(next).empty());
  EXPECT_TRUE(all<CreatePod>(next).empty());
  EXPECT_EQ(all<DeleteWorker>(next).size(), 1u);
  world.workers[0].deleted = world.now;
  settle(world);
  const auto other = all<CreateWorker>(plan(world, 1));
  ASSERT_EQ(other.size(), 1u);
  EXPECT_EQ(other[0].name, "render-1");
}

TEST(WhenThingsFail, RestoresEditedOrDeletedChildren) {
  ClusterState world = one_running(1);
  settle(world);
  world.workers[0].finalizer = false;
  world.pods[0].labelled = false;
  world.fleets[0].finalizer = false;
  EXPECT_EQ(all<Restore>(plan(world, 1)).size(), 2u);  // the pod's, once the finalizer is restored
  world.workers[0].finalizer = true;
  const auto restored = all<Restore>(plan(world, 1));
  ASSERT_EQ(restored.size(), 2u);
  EXPECT_EQ(restored[0].kind, Kind::kPod);
  EXPECT_EQ(restored[1].kind, Kind::kFleet);

  ClusterState undrained = one_running(1);
  undrained.workers[0].drain = Drain{DrainReason::kCordoned, undrained.now - 7};
  settle(undrained);
  undrained.workers[0].drain.reset();
  const auto drain = all<SetDrain>(plan(undrained, 1));
  ASSERT_EQ(drain.size(), 1u);
  EXPECT_EQ(drain[0].drain.reason, DrainReason::kCordoned);

  ClusterState deleted = one_running(1);
  deleted.workers[0].deleted = deleted.now;  // kubectl delete renderworker
  EXPECT_EQ(drained(deleted), DrainReason::kDeleted);
  EXPECT_EQ(all<CreateWorker>(plan(deleted, 1)).size(), 1u);
  EXPECT_TRUE(all<DeletePod>(plan(deleted, 1)).empty());

  ClusterState evicted = one_running(1);
  // kubectl delete pod: waits for its end, then creates it again
  evicted.pods[0].terminating = evicted.now;
  EXPECT_EQ(deeds(plan(evicted, 1)), 0u);
}

// drain, cordon
TEST(WhenThingsFail, CordonDrainsWithAGracePeriodForSessions) {
  ClusterState world = one_running(2);
  world.fleets[0].spec.drain_timeout = 60;
  world.nodes[0].cordoned = true;
  EXPECT_EQ(drained(world), DrainReason::kCordoned);
  world.workers[0].drain = Drain{DrainReason::kCordoned, world.now};
  EXPECT_TRUE(all<DeleteWorker>(plan(world, 1)).empty());
  world.now += 10;
  beat(world);
  world.telemetry[0].draining = true;
  EXPECT_TRUE(all<DeleteWorker>(plan(world, 1)).empty());  // two users are still viewing
  ClusterState empty = world;
  empty.telemetry[0].sessions = 0;
  EXPECT_EQ(all<DeleteWorker>(plan(empty, 1)).size(), 1u);
  empty.telemetry[0].reserved = 1;
  EXPECT_TRUE(all<DeleteWorker>(plan(empty, 1)).empty());
  empty.telemetry[0].reserved = 0;
  // it does not know of its drain yet, and may accept a session
  empty.telemetry[0].draining = false;
  EXPECT_TRUE(all<DeleteWorker>(plan(empty, 1)).empty());
  world.now += 50;
  EXPECT_EQ(all<DeleteWorker>(plan(world, 1)).size(), 1u);
}

TEST(WhenThingsFail, DeletedFleetDrainsItsWorkersBeforeItIsRemoved) {
  ClusterState world = one_running(1);
  world.fleets[0].deleted = world.now;
  EXPECT_EQ(drained(world), DrainReason::kDeleted);
  EXPECT_TRUE(all<CreateWorker>(plan(world, 1)).empty());
  EXPECT_TRUE(all<RemoveFinalizer>(plan(world, 1)).empty());
  world.workers.clear();
  world.pods.clear();
  const auto last = all<RemoveFinalizer>(plan(world, 1));
  ASSERT_EQ(last.size(), 1u);
  EXPECT_EQ(last[0].kind, Kind::kFleet);
}

TEST(Status, IsWrittenAtMostOncePerSecondAndOnlyOnChange) {
  ClusterState world = one_running(1);
  settle(world);
  EXPECT_TRUE(all<SetFleetStatus>(plan(world, 1)).empty());
  world.demand[0].used = 3;
  world.now += 0.5;
  EXPECT_TRUE(all<SetFleetStatus>(plan(world, 1)).empty());
  EXPECT_NEAR(plan(world, 1).requeue_after.value(), 0.5, 1e-9);
  world.now += 0.5;
  const auto written = all<SetFleetStatus>(plan(world, 1));
  ASSERT_EQ(written.size(), 1u);
  EXPECT_EQ(written[0].status.slots_used, 3);
  EXPECT_EQ(written[0].status.slots_total, 4);
  world.fleets[0].generation = 2;
  world.fleets[0].status.written = world.now;
  EXPECT_EQ(all<SetFleetStatus>(plan(world, 1)).at(0).status.observed_generation, 2);
}

}  // namespace
}  // namespace diaphane::fleet
