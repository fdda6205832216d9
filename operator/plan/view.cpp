#include "operator/plan/view.h"

#include <algorithm>
#include <cmath>

namespace diaphane::fleet {
namespace {

/// Grace period for the first heartbeat of a new pod.
constexpr Seconds kStarting = 120;

template <typename T>
std::vector<const T*> by_name(const std::vector<T>& all) {
  std::vector<const T*> sorted;
  sorted.reserve(all.size());
  for (const T& one : all) sorted.push_back(&one);
  std::sort(sorted.begin(), sorted.end(), [](const T* a, const T* b) { return a->name < b->name; });
  return sorted;
}

Health judge(const WorkerView& view, const ClusterState& world) {
  const Pod* pod = view.pod;
  // A worker with a heartbeat is alive, whatever a single read says about its pod or its node.
  if (view.heartbeat_fresh) return Health::kReady;
  if (!pod || pod->finished()) return Health::kComing;
  if (!pod->node.empty() && (!view.node || !view.node->ready || out_of_service(*view.node))) {
    return Health::kNodeLost;
  }
  if (pod->phase == Phase::kPending) return Health::kComing;
  if (!view.heartbeat_overdue) return pod->ready ? Health::kReady : Health::kComing;
  if (!view.telemetry && world.now - pod->created < kStarting) return Health::kComing;
  return Health::kUnhealthy;
}

/// Returns how long no heartbeat arrived although telemetry was available.
Seconds silence(const WorkerView& view, const ClusterState& world) {
  Seconds last = world.listening_since;
  if (view.pod) last = std::max(last, view.pod->created);
  if (view.telemetry) last = std::max(last, view.telemetry->sampled);
  return world.listened_until - last;
}

/// Returns how much silence is tolerated. A worker that has sent a heartbeat since telemetry became
/// available has less time than one that must reconnect.
Seconds patience(const WorkerView& view, const ClusterState& world) {
  const bool heard = view.telemetry && view.telemetry->sampled >= world.listening_since;
  return heard ? kHeartbeat : kFresh;
}

/// Whether at least half of the pods that have been ready for a while send telemetry.
bool fresh(const FleetView& fleet, const ClusterState& world) {
  std::size_t expected = 0, heard = 0;
  for (const WorkerView* view : fleet.workers) {
    if (!view->pod || !view->pod->ready || world.now - view->pod->created < kStarting) continue;
    ++expected;
    if (view->telemetry && world.now - view->telemetry->sampled <= kFresh) ++heard;
  }
  return 2 * heard >= expected;
}

void weigh(NodeView& node, const std::vector<const WorkerView*>& workers,
           const ClusterState& world) {
  double load = node.node->foreign_gpus;
  bool expected = false;
  Seconds newest = -kExcluded;
  for (const WorkerView* view : workers) {
    const std::optional<double> sample =
        view->telemetry ? load_of(*view->telemetry, world.now) : std::nullopt;
    // A worker without a sample counts as a whole GPU, and so does a reservation newer than the
    // last sample.
    load += sample.value_or(1);
    if (view->telemetry) newest = std::max(newest, view->telemetry->sampled);
    expected |= view->pod && view->pod->phase == Phase::kRunning && !view->pod->terminating &&
                world.now - view->pod->created > kStarting;
  }
  node.load = node.node->gpus > 0 ? load / node.node->gpus : load;
  node.silent =
      expected && world.now - newest > kExcluded && world.now - world.listening_since > kExcluded;
}

}  // namespace

std::optional<double> load_of(const Telemetry& sample, Seconds now) {
  if (now - sample.sampled > kFresh || sample.slots <= 0) return std::nullopt;
  const double taken = double(sample.sessions + sample.reserved) / sample.slots;
  const double load = std::max({sample.busy, sample.memory, taken, sample.error});
  const double sum = sample.busy + sample.memory + taken + sample.error;
  if (!std::isfinite(sum) || load < 0) return std::nullopt;
  return load;
}

bool out_of_service(const Node& node) {
  return std::any_of(node.taints.begin(), node.taints.end(), [](const Taint& taint) {
    return taint.key == "node.kubernetes.io/out-of-service";
  });
}

View build_view(const ClusterState& world) {
  View view;
  view.now = world.now;
  std::unordered_map<std::string_view, std::size_t> nodes;
  for (const Node* node : by_name(world.nodes)) {
    nodes.emplace(node->name, view.nodes.size());
    view.nodes.push_back({.node = node});
  }
  std::unordered_map<std::string_view, std::size_t> fleets;  // by uid
  for (const Fleet* fleet : by_name(world.fleets)) {
    fleets.emplace(fleet->uid, view.fleets.size());
    view.fleets.emplace_back().fleet = fleet;
  }
  for (const Demand& demand : world.demand) {
    for (FleetView& fleet : view.fleets) {
      if (fleet.fleet->name == demand.fleet) fleet.demand = &demand;
    }
  }
  std::unordered_map<std::string_view, std::size_t> owners;  // by uid
  std::unordered_map<std::string_view, std::size_t> named;
  view.workers.reserve(world.workers.size());
  for (const Worker* worker : by_name(world.workers)) {
    owners.emplace(worker->uid, view.workers.size());
    named.emplace(worker->name, view.workers.size());
    view.names.insert(worker->name);
    view.workers.push_back({.worker = worker});
  }
  const auto node_of = [&](const std::string& name) -> NodeView* {
    const auto found = nodes.find(name);
    return found == nodes.end() ? nullptr : &view.nodes[found->second];
  };
  for (const Pod& pod : world.pods) {
    view.names.insert(pod.name);
    const auto owner = pod.owned ? owners.find(pod.owner_uid) : owners.end();
    // A pod with another name is not the worker's pod, whatever its owner reference says, but its
    // GPU is in use.
    if (owner != owners.end() && view.workers[owner->second].worker->name == pod.name) {
      view.workers[owner->second].pod = &pod;
      continue;
    }
    if (const auto found = named.find(pod.name); found != named.end()) {
      view.workers[found->second].name_conflict = &pod;
    }
    if (!pod.owned || pod.finished()) continue;
    if (NodeView* node = node_of(pod.node)) ++node->reserved;
  }
  for (const Telemetry& sample : world.telemetry) {
    const auto found = owners.find(sample.worker_uid);
    if (found == owners.end()) continue;
    WorkerView& worker = view.workers[found->second];
    // Ignore delayed or repeated samples of an earlier pod of the worker.
    if (worker.pod ? sample.epoch != worker.pod->epoch || sample.sampled < worker.pod->created
                   : sample.epoch < worker.worker->status.epoch) {
      continue;
    }
    worker.telemetry = &sample;
    worker.heartbeat_fresh = world.now - sample.sampled <= kHeartbeat;
  }
  std::vector<std::vector<const WorkerView*>> on(view.nodes.size());
  for (WorkerView& worker : view.workers) {
    if (NodeView* node = node_of(worker.worker->node)) {
      worker.node = node->node;
      ++node->reserved;
      on[static_cast<std::size_t>(node - view.nodes.data())].push_back(&worker);
    }
    const auto fleet = fleets.find(worker.worker->fleet_uid);
    if (fleet == fleets.end()) continue;
    worker.fleet = view.fleets[fleet->second].fleet;
    view.fleets[fleet->second].workers.push_back(&worker);
  }
  for (FleetView& fleet : view.fleets) fleet.metrics_fresh = fresh(fleet, world);
  for (WorkerView& worker : view.workers) {
    const auto fleet = fleets.find(worker.worker->fleet_uid);
    const bool metrics = fleet == fleets.end() || view.fleets[fleet->second].metrics_fresh;
    worker.heartbeat_age = silence(worker, world);
    worker.heartbeat_overdue = metrics && worker.heartbeat_age > patience(worker, world);
    worker.health = judge(worker, world);
  }
  for (std::size_t i = 0; i < view.nodes.size(); ++i) weigh(view.nodes[i], on[i], world);
  return view;
}

}  // namespace diaphane::fleet
