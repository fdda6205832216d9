// Properties of the plan in random worlds, executed by the simulated cluster with all of its
// faults. Each seed gives another world.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <map>
#include <set>

#include "operator/plan/scale.h"
#include "tests/support/operator/simulated_cluster.h"
#include "tests/support/operator/test_world.h"

namespace diaphane::fleet {
namespace {

class Worlds : public testing::TestWithParam<int> {};

/// What one plan reserves must fit beside what its world contains.
void expect_room(const ClusterState& world, const Plan& plan) {
  std::map<std::string, int> taken;
  for (const Worker& worker : world.workers) taken[worker.node] += worker.gpus;
  std::set<std::string> names;
  for (const CreateWorker& made : all<CreateWorker>(plan)) {
    const auto fleet = std::find_if(world.fleets.begin(), world.fleets.end(),
                                    [&](const Fleet& f) { return f.uid == made.fleet_uid; });
    ASSERT_NE(fleet, world.fleets.end());
    taken[made.node] += fleet->spec.gpus_per_worker;
    EXPECT_TRUE(names.insert(made.name).second) << made.name << " twice in one plan";
    const auto node = std::find_if(world.nodes.begin(), world.nodes.end(),
                                   [&](const Node& n) { return n.name == made.node; });
    ASSERT_NE(node, world.nodes.end());
    EXPECT_LE(taken[made.node] + node->foreign_gpus, node->gpus) << "on " << made.node;
    EXPECT_FALSE(node->cordoned);
  }
}

/// A cluster and an operator whose caches lag, whose writes fail, and which dies between them.
class Chaos {
 public:
  explicit Chaos(int seed) : cluster_(static_cast<std::uint64_t>(seed)), seed_(seed) {
    const int nodes = 1 + cluster_.up_to(5);
    for (int i = 0; i < nodes; ++i) {
      Node& node = cluster_.add_node("node-" + std::to_string(i), cluster_.up_to(4));
      if (node.gpus > 1 && cluster_.chance(0.2)) node.foreign_gpus = 1;
      if (cluster_.chance(0.8)) node.labels["gpu"] = "yes";
      nodes_.push_back(node.name);
    }
    const int fleets = 1 + cluster_.up_to(1);
    for (int i = 0; i < fleets; ++i) {
      Fleet& fleet = cluster_.add_fleet("fleet-" + std::to_string(i));
      fleet.spec.sessions_per_worker = 1 + cluster_.up_to(4);
      fleet.spec.min_idle_slots = cluster_.up_to(3);
      fleet.spec.max_refill_per_second = cluster_.chance(0.5) ? 0 : 0.5 + cluster_.up_to(2);
      fleet.spec.drain_timeout = 20 + cluster_.up_to(40);
      fleet.spec.max_replicas = 1 + cluster_.up_to(12);
      if (cluster_.chance(0.5)) fleet.spec.scale_to_zero_after = 30;
      if (cluster_.chance(0.3)) fleet.spec.replicas = cluster_.up_to(5);
      if (cluster_.chance(0.3)) fleet.spec.strategy = Strategy::kPacked;
      if (cluster_.chance(0.3)) fleet.spec.node_selector["gpu"] = "yes";
      if (cluster_.chance(0.3)) fleet.spec.gpus_per_worker = 2 + cluster_.up_to(1);
      fleets_.push_back(fleet.name);
    }
  }

  /// One round of the operator, with all but its own resources `lag` rounds old.
  Plan reconcile(bool faults) {
    ClusterState world = cluster_.observed();
    past_.push_back(world);
    if (past_.size() > 4) past_.pop_front();
    if (faults && cluster_.chance(0.4)) world.pods = some_past().pods;
    if (faults && cluster_.chance(0.4)) world.nodes = some_past().nodes;
    if (faults && cluster_.chance(0.4)) world.telemetry = some_past().telemetry;
    if (faults && cluster_.chance(0.05)) world.nodes.clear();  // an odd read
    if (faults && cluster_.chance(0.05)) world.pods.clear();
    const Plan made = plan(world, random_++);
    if (checks_room) expect_room(world, made);
    for (const Action& action : made.actions) {
      if (faults && cluster_.chance(0.05)) break;    // the operator dies, and another leads
      if (faults && cluster_.chance(0.1)) continue;  // this write failed
      cluster_.apply(action);
      if (faults && cluster_.chance(0.2)) cluster_.apply(action);  // executed twice
    }
    return made;
  }

  void trouble() {
    const std::string node =
        nodes_[static_cast<std::size_t>(cluster_.up_to(int(nodes_.size()) - 1))];
    ClusterState& world = cluster_.world();
    const auto some_worker = [&]() -> Worker* {
      if (world.workers.empty()) return nullptr;
      return &world
                  .workers[static_cast<std::size_t>(cluster_.up_to(int(world.workers.size()) - 1))];
    };
    Worker* worker = some_worker();
    switch (cluster_.up_to(13)) {
      case 0:
        if (worker) cluster_.crash_pod(worker->name);
        break;
      case 1:
        cluster_.lose_node(node);
        break;
      case 2:
        cluster_.return_node(node);
        break;
      case 3:
      case 4:
        for (Node& one : world.nodes) {
          if (one.name == node) one.cordoned = !one.cordoned;
        }
        break;
      case 5:
        if (worker) cluster_.hang(worker->name, cluster_.chance(0.5));
        break;
      case 6:
        cluster_.silence(cluster_.chance(0.5));
        break;
      case 7:
        cluster_.refuse(node, cluster_.chance(0.5));
        break;
      case 8:  // by hand
        if (worker && !worker->deleted) worker->deleted = world.now;
        break;
      case 9:
        if (worker) worker->finalizer = worker->deleted.has_value();
        break;
      case 10:
        if (worker) worker->drain.reset();
        break;
      case 11:
        for (Pod& pod : world.pods) {
          if (pod.owned && cluster_.chance(0.2)) pod.labelled = false;
        }
        break;
      case 12: {
        Fleet& fleet =
            world.fleets[static_cast<std::size_t>(cluster_.up_to(int(world.fleets.size()) - 1))];
        fleet.spec.template_hash = "hash-" + std::to_string(cluster_.up_to(2));
        ++fleet.generation;
        break;
      }
      default: {  // a foreign pod with Diaphane's label takes a name
        Pod pod;
        pod.name = fleets_.front() + "-" + std::to_string(cluster_.up_to(3));
        pod.uid = "foreign-" + std::to_string(world.now);
        const bool taken = std::any_of(world.pods.begin(), world.pods.end(),
                                       [&](const Pod& p) { return p.name == pod.name; });
        if (!taken && cluster_.chance(0.3)) world.pods.push_back(pod);
      }
    }
    people();
  }

  void people() {
    for (const std::string& fleet : fleets_) {
      if (cluster_.chance(0.3)) cluster_.want_sessions(fleet, cluster_.up_to(12));
    }
  }

  /// Ends all faults. Users still want their sessions.
  void mend() {
    for (const std::string& node : nodes_) {
      cluster_.return_node(node);
      cluster_.refuse(node, false);
    }
    for (const Worker& worker : cluster_.world().workers) cluster_.hang(worker.name, false);
    for (Node& node : cluster_.world().nodes) node.cordoned = false;
    cluster_.silence(false);
  }

  void run(int seconds, bool faults) {
    for (int i = 0; i < seconds; ++i) {
      if (faults && cluster_.chance(0.3)) trouble();
      reconcile(faults);
      cluster_.step();
    }
  }

  SimulatedCluster& cluster() { return cluster_; }
  const ClusterState& some_past() {
    return past_[static_cast<std::size_t>(cluster_.up_to(int(past_.size()) - 1))];
  }
  bool checks_room = true;

 private:
  SimulatedCluster cluster_;
  int seed_;
  std::uint64_t random_ = 1;
  std::deque<ClusterState> past_;
  std::vector<std::string> nodes_, fleets_;
};

std::string said(const std::vector<std::string>& violations) {
  std::string words;
  for (const std::string& one : violations) words += one + "; ";
  return words;
}

/// Returns for how many more workers of the fleet there are GPUs.
int room_for(const Fleet& fleet, const ClusterState& world) {
  int room = 0;
  for (const Node& node : world.nodes) {
    int free = node.gpus - node.foreign_gpus;
    for (const Worker& worker : world.workers) free -= worker.node == node.name ? worker.gpus : 0;
    room += std::max(free, 0) / fleet.spec.gpus_per_worker;
  }
  return room;
}

/// All workers are ready and current, and there are as many as desired or as fit.
void expect_settled(const ClusterState& world) {
  const Plan next = plan(world, 1);
  EXPECT_EQ(deeds(next), 0u) << "action " << next.actions.front().index();
  for (const Fleet& fleet : world.fleets) {
    const int room = room_for(fleet, world);
    int ready = 0, outdated = 0;
    bool idle = false;
    for (const Worker& worker : world.workers) {
      if (worker.fleet != fleet.name) continue;
      EXPECT_FALSE(worker.drain) << worker.name << " still drains";
      EXPECT_FALSE(worker.deleted);
      EXPECT_TRUE(worker.finalizer && worker.labelled);
      const Condition* is = nullptr;
      for (const Condition& one : worker.status.conditions) {
        if (one.type == "Ready") is = &one;
      }
      ready += is && is->status == ConditionStatus::kTrue;
      for (const Telemetry& sample : world.telemetry) {
        idle |= sample.worker_uid == worker.uid && sample.sessions == 0;
      }
      outdated += worker.template_hash != fleet.spec.template_hash;
    }
    const Demand* demand = nullptr;
    for (const Demand& one : world.demand) {
      if (one.fleet == fleet.name) demand = &one;
    }
    const DesiredReplicas desired = desired_replicas(fleet.spec, demand, ready, world.now);
    const bool limited = std::any_of(
        fleet.status.conditions.begin(), fleet.status.conditions.end(), [](const Condition& c) {
          return c.type == "CapacityLimited" && c.status == ConditionStatus::kTrue;
        });
    // A worker with a session stays, even if it is not needed.
    EXPECT_TRUE(ready <= desired.most || !idle) << fleet.name;
    if (ready < desired.least) {
      EXPECT_TRUE(limited && (room == 0 || !fleet.spec.node_selector.empty()))
          << fleet.name << " has " << ready << " of " << desired.least << ", room " << room;
    } else {
      EXPECT_FALSE(limited) << fleet.name;
    }
    const bool tight = room == 0 || !fleet.spec.node_selector.empty();
    EXPECT_TRUE(outdated == 0 || tight) << fleet.name;
  }
}

TEST_P(Worlds, NeverOvercommitNorMoveReservationsAndConverge) {
  Chaos chaos(GetParam());
  chaos.run(150, true);
  chaos.mend();
  chaos.run(900, false);
  const ClusterState world = chaos.cluster().observed();
  expect_settled(world);
  EXPECT_TRUE(chaos.cluster().violations().empty()) << said(chaos.cluster().violations());
}

TEST_P(Worlds, DeletedFleetReleasesEveryReservation) {
  Chaos chaos(GetParam());
  chaos.run(100, true);
  chaos.mend();
  for (Fleet& fleet : chaos.cluster().world().fleets) {
    fleet.finalizer = true;
    fleet.deleted = chaos.cluster().world().now;
  }
  chaos.run(300, false);
  const ClusterState& world = chaos.cluster().world();
  EXPECT_TRUE(world.workers.empty()) << world.workers.front().name;
  EXPECT_TRUE(world.fleets.empty());
  for (const Pod& pod : world.pods) EXPECT_FALSE(pod.owned) << pod.name;
  EXPECT_TRUE(chaos.cluster().violations().empty()) << said(chaos.cluster().violations());
}

TEST_P(Worlds, PlansAreDeterministicAndIdempotent) {
  Chaos chaos(GetParam());
  std::mt19937_64 random(static_cast<std::uint64_t>(GetParam()));
  for (int i = 0; i < 100; ++i) {
    chaos.run(1, true);
    ClusterState world = chaos.cluster().observed();
    const Plan once = plan(world, 5), again = plan(world, 5);
    std::shuffle(world.workers.begin(), world.workers.end(), random);
    std::shuffle(world.pods.begin(), world.pods.end(), random);
    std::shuffle(world.nodes.begin(), world.nodes.end(), random);
    std::shuffle(world.telemetry.begin(), world.telemetry.end(), random);
    const Plan shuffled = plan(world, 5);
    ASSERT_EQ(once.actions.size(), again.actions.size());
    ASSERT_EQ(once.actions.size(), shuffled.actions.size());
    EXPECT_EQ(once.requeue_after, again.requeue_after);
    EXPECT_EQ(all<CreateWorker>(once), all<CreateWorker>(shuffled));
    EXPECT_EQ(all<CreatePod>(once), all<CreatePod>(shuffled));
    EXPECT_EQ(all<SetDrain>(once), all<SetDrain>(shuffled));
    EXPECT_EQ(all<DeleteWorker>(once), all<DeleteWorker>(again));
    EXPECT_EQ(all<DeletePod>(once), all<DeletePod>(again));
    EXPECT_EQ(all<SetWorkerStatus>(once), all<SetWorkerStatus>(shuffled));
    SimulatedCluster one = chaos.cluster();
    for (const Action& action : once.actions) one.apply(action);
    const std::size_t workers = one.world().workers.size(), pods = one.world().pods.size();
    // The next leader has other random numbers, but the same needs.
    for (const Action& action : plan(world, 6).actions) one.apply(action);
    EXPECT_EQ(one.world().workers.size(), workers);
    EXPECT_EQ(one.world().pods.size(), pods);
  }
}

TEST_P(Worlds, OperatorPausedBeyondItsLeaseKeepsReservations) {
  Chaos chaos(GetParam());
  chaos.run(60, false);
  for (int i = 0; i < 6; ++i) {
    // It planned, was suspended, and executes its plan after another one has led for a while.
    const Plan paused = plan(chaos.cluster().observed(), 77);
    for (int second = 0; second < 5 * (i + 1); ++second) {
      if (chaos.cluster().chance(0.3)) chaos.people();
      chaos.run(1, false);
    }
    if (i % 2 == 1) chaos.trouble();
    for (const Action& action : paused.actions) chaos.cluster().apply(action);
    for (const Node& node : chaos.cluster().world().nodes) {
      EXPECT_LE(chaos.cluster().gpus_on(node.name) + node.foreign_gpus,
                std::max(node.gpus, node.foreign_gpus));
    }
  }
  chaos.mend();
  chaos.run(900, false);
  const ClusterState world = chaos.cluster().observed();
  expect_settled(world);
  EXPECT_TRUE(chaos.cluster().violations().empty()) << said(chaos.cluster().violations());
}

/// DIAPHANE_WORLDS sets a larger number of worlds.
int worlds() {
  const char* many = std::getenv("DIAPHANE_WORLDS");
  return many ? std::max(1, std::atoi(many)) : 60;
}

INSTANTIATE_TEST_SUITE_P(Seeds, Worlds, testing::Range(1, 1 + worlds()));

}  // namespace
}  // namespace diaphane::fleet
