#pragma once

#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "operator/plan/plan.h"
#include "operator/plan/world.h"

// A world with everything found that belongs together, and judged.

namespace diaphane::fleet {

enum class Health {
  kComing,     ///< its pod is to be made, starts, or has ended and is made again
  kReady,      ///< takes sessions
  kUnhealthy,  ///< its pod should run and is not heard of
  kNodeLost    ///< neither its node nor it is heard of
};

struct WorkerView {
  const Worker* worker = nullptr;
  const Fleet* fleet = nullptr;  ///< of its uid
  const Node* node = nullptr;
  const Pod* pod = nullptr;              ///< its own
  const Pod* in_the_way = nullptr;       ///< another's, of its name
  const Telemetry* telemetry = nullptr;  ///< of its last pod
  bool beats = false;
  Seconds silent = 0;          ///< so long it was listened for and not heard
  bool silence_counts = true;  ///< that is too long, and others are heard of
  Health health = Health::kComing;

  bool leaving() const { return worker->drain || worker->deleted; }
};

struct NodeView {
  const Node* node = nullptr;
  int reserved = 0;     ///< by workers, and by pods whose worker has gone
  double load = 0;      ///< of its GPUs, 1: all of them full (more where pictures are noisy)
  bool silent = false;  ///< telemetry is older than kExcluded where there should be some

  int free() const { return node->gpus - node->foreign_gpus - reserved; }
};

struct FleetView {
  const Fleet* fleet = nullptr;
  const Demand* demand = nullptr;
  std::vector<const WorkerView*> workers;  ///< by name
  /// Most of its ready pods are heard of. Where not, it is not they who are away, but what carries
  /// their telemetry.
  bool metrics_fresh = true;
};

struct View {
  Seconds now = 0;
  std::vector<WorkerView> workers;  ///< by name, as all of these
  std::vector<NodeView> nodes;
  std::vector<FleetView> fleets;
  std::unordered_set<std::string_view> names;  ///< of workers and pods: taken
};

/// Points into `world`.
View look(const World& world);

/// max(busy, memory, slots taken, summed error); nothing of a sample that is old or makes no sense.
std::optional<double> load_of(const Telemetry& sample, Seconds now);

/// No kubelet of that node will ever end a pod.
bool out_of_service(const Node& node);

}  // namespace diaphane::fleet
