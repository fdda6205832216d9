// Where a worker is placed: one case per sentence of "Placing".
#include "operator/plan/placing.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <set>

#include "tests/support/operator/test_world.h"

namespace diaphane::fleet {
namespace {

std::string node_of(const ClusterState& world, std::uint64_t seed = 1) {
  const auto made = all<CreateWorker>(plan(world, seed));
  return made.empty() ? "" : made.front().node;
}

/// Returns how often each node gets the next worker.
std::map<std::string, int> drawn(const ClusterState& world) {
  std::map<std::string, int> counts;
  for (std::uint64_t seed = 0; seed < 200; ++seed) ++counts[node_of(world, seed)];
  return counts;
}

ClusterState wanting_one(int nodes) {
  ClusterState world = test_world(nodes);
  world.fleets[0].spec.replicas = 1;
  return world;
}

/// Another fleet's worker on that node, with this sample.
void occupy(ClusterState& world, const std::string& node, double busy, double memory, int sessions,
            double error, Seconds age = 1) {
  if (world.fleets.size() == 1) {
    Fleet other = world.fleets[0];
    other.name = "other";
    other.uid = "other-uid";
    other.spec.replicas.reset();
    other.spec.min_replicas = 0;
    world.fleets.push_back(other);
  }
  Worker& worker = add_worker(world, 100 + static_cast<int>(world.workers.size()), node);
  worker.fleet = "other";
  worker.fleet_uid = "other-uid";
  const Worker copy = worker;
  add_pod(world, copy);
  Telemetry& sample = add_sample(world, copy, sessions, age);
  sample.busy = busy;
  sample.memory = memory;
  sample.error = error;
}

TEST(Placing, CountsEachOfTheFourLoads) {
  const struct {
    double busy, memory;
    int sessions;
    double error;
  } cases[] = {{0.9, 0, 0, 0}, {0, 0.9, 0, 0}, {0, 0, 4, 0}, {0, 0, 0, 0.9}};
  for (const auto& one : cases) {
    ClusterState world = wanting_one(2);
    occupy(world, "a", one.busy, one.memory, one.sessions, one.error);
    occupy(world, "b", 0.1, 0.1, 0, 0.1);
    EXPECT_EQ(drawn(world), (std::map<std::string, int>{{"b", 200}}));
  }
}

TEST(Placing, ReservationWithoutSampleCountsAsWholeGpu) {
  ClusterState world = wanting_one(2);
  occupy(world, "a", 0.1, 0, 0, 0);
  occupy(world, "b", 0.1, 0, 0, 0);
  world.telemetry.pop_back();
  EXPECT_EQ(drawn(world), (std::map<std::string, int>{{"a", 200}}));
}

TEST(Placing, TelemetryOverTenSecondsOldFallsBackToCounts) {
  ClusterState world = wanting_one(2);
  occupy(world, "a", 0.0, 0, 0, 0, 11);
  occupy(world, "b", 0.7, 0, 0, 0);
  EXPECT_EQ(drawn(world), (std::map<std::string, int>{{"b", 200}}));
  world.telemetry[0].sampled = world.now - 9;
  EXPECT_EQ(drawn(world), (std::map<std::string, int>{{"a", 200}}));
}

TEST(Placing, TelemetryOverSixtySecondsOldExcludesTheNode) {
  ClusterState world = wanting_one(1);
  occupy(world, "a", 0.0, 0, 0, 0, 59);
  EXPECT_EQ(node_of(world), "a");
  world.telemetry[0].sampled = world.now - 61;
  EXPECT_EQ(node_of(world), "");
  world.listening_since = world.now - 20;  // an operator that has just started knows nothing yet
  EXPECT_EQ(node_of(world), "a");
}

TEST(Placing, IgnoresInvalidSamples) {
  const double odd[] = {std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::infinity(), -5};
  for (const double value : odd) {
    Telemetry sample;
    sample.slots = 4;
    sample.busy = sample.memory = sample.error = value;
    if (value < 0) sample.sessions = -3;
    EXPECT_FALSE(load_of(sample, 1).has_value()) << value;
  }
  Telemetry slotless;
  EXPECT_FALSE(load_of(slotless, 1).has_value());
}

TEST(Placing, ComparesTwoRandomNodesWithinATenthOfTheLeastLoaded) {
  const std::vector<Candidate> nodes{{0.50, 1}, {0.55, 1}, {0.59, 1}, {0.61, 1}, {0.1, 0}};
  std::map<std::size_t, int> counts;
  Random random(3);
  for (int i = 0; i < 9000; ++i) ++counts[*choose(nodes, Strategy::kLeastLoaded, random)];
  // Two draws of three nodes: the best is among them in 5 of 9 cases, and the worst is taken in 1.
  EXPECT_EQ(counts.size(), 3u);
  EXPECT_NEAR(counts[0], 5000, 250);
  EXPECT_NEAR(counts[1], 3000, 250);
  EXPECT_NEAR(counts[2], 1000, 200);
}

TEST(Placing, ChoosesNoNodeWithoutRoom) {
  Random random(1);
  const std::vector<Candidate> full{{0.1, 0}, {0.2, -1}};
  EXPECT_FALSE(choose(full, Strategy::kLeastLoaded, random));
  EXPECT_FALSE(choose(full, Strategy::kPacked, random));
  EXPECT_FALSE(choose({}, Strategy::kLeastLoaded, random));
}

TEST(Placing, PackedFillsTheFullestNode) {
  ClusterState world = wanting_one(3);
  world.fleets[0].spec.strategy = Strategy::kPacked;
  occupy(world, "b", 0.9, 0, 0, 0);
  EXPECT_EQ(drawn(world), (std::map<std::string, int>{{"b", 200}}));
}

TEST(Placing, SpreadsOverEqualNodes) {
  ClusterState world = wanting_one(8);
  EXPECT_EQ(drawn(world).size(), 8u);
  world.fleets[0].spec.replicas = 8;
  std::map<std::string, int> counts;
  for (const CreateWorker& made : all<CreateWorker>(plan(world, 1))) ++counts[made.node];
  for (const auto& [node, count] : counts) EXPECT_EQ(count, 1) << node;
}

TEST(Placing, SkipsUnsuitableNodesAndReportsWhy) {
  const struct {
    const char* why;
    void (*change)(ClusterState&);
  } cases[] = {
      {"0 of 1 nodes have room: 1 not ready", [](ClusterState& w) { w.nodes[0].ready = false; }},
      {"0 of 1 nodes have room: 1 cordoned", [](ClusterState& w) { w.nodes[0].cordoned = true; }},
      {"0 of 1 nodes have room: 1 not selected",
       [](ClusterState& w) { w.fleets[0].spec.node_selector["zone"] = "north"; }},
      {"0 of 1 nodes have room: 1 tainted",
       [](ClusterState& w) {
         w.nodes[0].taints.push_back({"gpu", "yes", "NoSchedule"});
       }},
      {"0 of 1 nodes have room: 1 full", [](ClusterState& w) { w.nodes[0].foreign_gpus = 2; }},
      {"0 of 1 nodes have room: 1 with too few GPUs", [](ClusterState& w) { w.nodes[0].gpus = 0; }},
      {"0 of 1 nodes have room: 1 with too few GPUs",
       [](ClusterState& w) { w.fleets[0].spec.gpus_per_worker = w.nodes[0].gpus + 1; }},
      {"0 of 1 nodes have room: 1 rejected recently",
       [](ClusterState& w) {
         w.fleets[0].status.refusals.push_back({"a", 1, w.now - 1});
       }},
      {"0 of 0 nodes have room", [](ClusterState& w) { w.nodes.clear(); }},
  };
  for (const auto& one : cases) {
    ClusterState world = wanting_one(1);
    one.change(world);
    const Plan made = plan(world, 1);
    EXPECT_TRUE(all<CreateWorker>(made).empty()) << one.why;
    const auto status = all<SetFleetStatus>(made);
    ASSERT_EQ(status.size(), 1u);
    bool limited = false;
    for (const Condition& is : status[0].status.conditions) {
      if (is.type != "CapacityLimited") continue;
      limited = is.status == ConditionStatus::kTrue;
      EXPECT_EQ(is.message, std::string("Missing workers: 1. ") + one.why);
    }
    EXPECT_TRUE(limited) << one.why;
  }
}

TEST(Placing, IgnoresToleratedAndPreferredTaints) {
  ClusterState world = wanting_one(1);
  world.nodes[0].taints = {{"gpu", "yes", "NoSchedule"}, {"slow", "", "PreferNoSchedule"}};
  world.fleets[0].spec.tolerations.push_back({"gpu", "", "NoSchedule"});
  EXPECT_EQ(node_of(world), "a");
  world.fleets[0].spec.tolerations[0].value = "no";
  EXPECT_EQ(node_of(world), "");
}

TEST(Placing, RetriesFailedNodeAfterItsBackoff) {
  ClusterState world = wanting_one(1);
  world.fleets[0].status.refusals.push_back({"a", 3, world.now - 19});
  EXPECT_EQ(node_of(world), "");
  EXPECT_NEAR(plan(world, 1).requeue_after.value(), 1, 1e-6);  // 5 s, 10 s, 20 s
  world.now += 1.01;
  EXPECT_EQ(node_of(world), "a");
}

TEST(Placing, AWorkerTakesAllOfItsGpusOnOneNode) {
  ClusterState world = wanting_one(3);
  world.nodes[0].gpus = 5;
  world.nodes[1].gpus = 3;
  world.nodes[2].gpus = 4;
  world.fleets[0].spec.gpus_per_worker = 4;
  world.fleets[0].spec.replicas = 3;
  std::set<std::string> nodes;
  for (const CreateWorker& made : all<CreateWorker>(plan(world, 1))) nodes.insert(made.node);
  EXPECT_EQ(nodes, (std::set<std::string>{world.nodes[0].name, world.nodes[2].name}))
      << "5 and 4 GPUs have room for one worker each, 3 for none";
}

TEST(Placing, AWorkerWithSeveralGpusWeighsAsManyTimes) {
  ClusterState world = wanting_one(2);
  for (Node& node : world.nodes) node.gpus = 8;
  occupy(world, "a", 0.5, 0, 0, 0);
  occupy(world, "b", 0.5, 0, 0, 0);
  world.workers[0].gpus = 4;
  EXPECT_EQ(drawn(world), (std::map<std::string, int>{{"b", 200}}));
}

TEST(Placing, OrphanedPodHoldsItsGpu) {
  ClusterState world = wanting_one(1);
  world.nodes[0].gpus = 1;
  Pod pod;
  pod.name = "render-9";
  pod.owned = true;
  pod.owner_uid = "gone";
  pod.node = "a";
  pod.phase = Phase::kRunning;
  world.pods.push_back(pod);
  EXPECT_EQ(node_of(world), "");
  world.pods[0].phase = Phase::kFailed;
  EXPECT_EQ(node_of(world), "a");
}

}  // namespace
}  // namespace diaphane::fleet
