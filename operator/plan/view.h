#pragma once

#include <algorithm>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "operator/plan/cluster_state.h"
#include "operator/plan/plan.h"

// The world with its objects linked to each other and assessed.

namespace diaphane::fleet {

enum class Health {
  kComing,     ///< its pod will be created, is starting, or has ended and will be recreated
  kReady,      ///< accepts sessions
  kUnhealthy,  ///< its pod should be running, but sends no heartbeat
  kNodeLost    ///< neither its node nor its pod sends a heartbeat
};

struct WorkerView {
  const Worker* worker = nullptr;
  const Fleet* fleet = nullptr;  ///< the fleet that the worker belongs to, by uid
  const Node* node = nullptr;
  const Pod* pod = nullptr;              ///< its own pod
  const Pod* name_conflict = nullptr;    ///< another worker's pod of the same name
  const Telemetry* telemetry = nullptr;  ///< last sample of its pod
  bool heartbeat_fresh = false;
  Seconds heartbeat_age = 0;      ///< seconds without a heartbeat while listening
  bool heartbeat_overdue = true;  ///< `heartbeat_age` is too long, but other pods send heartbeats
  Health health = Health::kComing;

  bool leaving() const { return worker->drain || worker->deleted; }
};

struct NodeView {
  const Node* node = nullptr;
  int reserved = 0;     ///< GPUs in use by workers and by pods whose worker no longer exists
  double load = 0;      ///< relative to its GPUs, 1: all full (more if pictures are noisy)
  bool silent = false;  ///< expected telemetry is older than kExcluded

  /// Returns for how many more workers with this number of GPUs each there is room.
  int room(int gpus_per_worker) const {
    return std::max(node->gpus - node->foreign_gpus - reserved, 0) / std::max(gpus_per_worker, 1);
  }
};

struct FleetView {
  const Fleet* fleet = nullptr;
  const Demand* demand = nullptr;
  std::vector<const WorkerView*> workers;  ///< by name
  /// At least half of its ready pods send telemetry. Otherwise, the fault is in the telemetry and
  /// not in the pods.
  bool metrics_fresh = true;
};

struct View {
  Seconds now = 0;
  std::vector<WorkerView> workers;  ///< sorted by name, like the other lists
  std::vector<NodeView> nodes;
  std::vector<FleetView> fleets;
  std::unordered_set<std::string_view> names;  ///< names of workers and pods in use
};

/// Returns a view whose pointers refer to `world`.
View build_view(const ClusterState& world);

/// Returns max(busy, memory, slots taken, summed error), or nullopt for an old or implausible
/// sample.
std::optional<double> load_of(const Telemetry& sample, Seconds now);

/// Returns whether the node is marked as out of service, so that no kubelet will ever end its pods.
bool out_of_service(const Node& node);

}  // namespace diaphane::fleet
