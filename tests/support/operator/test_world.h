#pragma once

#include <string>
#include <variant>
#include <vector>

#include "operator/plan/plan.h"

// Small worlds for table-driven tests.

namespace diaphane::fleet {

inline constexpr Seconds kNow = 1'000'000;

/// A fleet `render` with its finalizer, no demand, and nodes `a`, `b`, ... with two GPUs each.
inline ClusterState test_world(int nodes = 2) {
  ClusterState world;
  world.now = kNow;
  world.complete = true;
  world.listened_until = kNow;
  Fleet fleet;
  fleet.name = "render";
  fleet.uid = "fleet-uid";
  fleet.version = "1";
  fleet.finalizer = true;
  fleet.spec.sessions_per_worker = 4;
  fleet.spec.template_hash = "one";
  fleet.status.observed_generation = 1;
  world.fleets.push_back(fleet);
  world.demand.push_back({"render", 0, 0, 0, kNow, kNow});
  for (int i = 0; i < nodes; ++i) {
    Node node;
    node.name = std::string(1, static_cast<char>('a' + i));
    node.gpus = 2;
    world.nodes.push_back(node);
  }
  return world;
}

inline Worker& add_worker(ClusterState& world, int ordinal, const std::string& node) {
  Worker worker;
  worker.name = "render-" + std::to_string(ordinal);
  worker.uid = "uid-" + std::to_string(ordinal);
  worker.version = "7";
  worker.fleet = "render";
  worker.fleet_uid = "fleet-uid";
  worker.node = node;
  worker.status.epoch = 1;
  worker.template_hash = "one";
  worker.created = kNow - 1000;
  world.workers.push_back(worker);
  return world.workers.back();
}

inline Pod& add_pod(ClusterState& world, const Worker& worker) {
  Pod pod;
  pod.name = worker.name;
  pod.uid = "pod-of-" + worker.uid;
  pod.owned = true;
  pod.owner_uid = worker.uid;
  pod.epoch = worker.status.epoch;
  pod.node = worker.node;
  pod.phase = Phase::kRunning;
  pod.ready = true;
  pod.created = kNow - 900;
  world.pods.push_back(pod);
  return world.pods.back();
}

inline Telemetry& add_sample(ClusterState& world, const Worker& worker, int sessions,
                             Seconds age = 1) {
  Telemetry sample;
  sample.worker_uid = worker.uid;
  sample.epoch = worker.status.epoch;
  sample.sampled = world.now - age;
  sample.sessions = sessions;
  sample.slots = 4;
  sample.busy = 0.1;
  sample.idle_since = sessions > 0 ? sample.sampled : kNow - 900;
  world.telemetry.push_back(sample);
  return world.telemetry.back();
}

/// Adds a worker whose pod runs and sends heartbeats.
inline void add_running(ClusterState& world, int ordinal, const std::string& node, int sessions) {
  add_worker(world, ordinal, node);
  const Worker worker = world.workers.back();
  add_pod(world, worker);
  add_sample(world, worker, sessions);
  for (Demand& demand : world.demand) demand.used += sessions;
}

template <typename T>
std::vector<T> all(const Plan& plan) {
  std::vector<T> found;
  for (const Action& action : plan.actions) {
    if (const T* one = std::get_if<T>(&action)) found.push_back(*one);
  }
  return found;
}

/// Counts the actions that change anything but status.
inline std::size_t deeds(const Plan& plan) {
  std::size_t count = 0;
  for (const Action& action : plan.actions) {
    count += !std::holds_alternative<SetFleetStatus>(action) &&
             !std::holds_alternative<SetWorkerStatus>(action);
  }
  return count;
}

}  // namespace diaphane::fleet
