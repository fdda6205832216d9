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
  const bool reporting = view.telemetry && view.telemetry->sampled >= world.listening_since;
  return reporting ? kHeartbeat : kFresh;
}

/// Returns whether at least half of the pods that have been ready for a while send telemetry.
bool fresh(const FleetView& fleet, const ClusterState& world) {
  std::size_t expected = 0, reporting = 0;
  for (const WorkerView* view : fleet.workers) {
    if (!view->pod || !view->pod->ready || world.now - view->pod->created < kStarting) continue;
    ++expected;
    if (view->telemetry && world.now - view->telemetry->sampled <= kFresh) ++reporting;
  }
  return 2 * reporting >= expected;
}

void weigh(NodeView& node, const std::vector<const WorkerView*>& workers,
           const ClusterState& world) {
  double load = node.node->foreign_gpus;
  bool expected = false;
  Seconds newest = -kExcluded;
  for (const WorkerView* view : workers) {
    const std::optional<double> sample =
        view->telemetry ? load_of(*view->telemetry, world.now) : std::nullopt;
    // A worker without a sample counts as busy, and so does a reservation newer than the last
    // sample. A sample describes the GPUs of its worker together.
    load += view->worker->gpus * sample.value_or(1);
    if (view->telemetry) newest = std::max(newest, view->telemetry->sampled);
    expected |= view->pod && view->pod->phase == Phase::kRunning && !view->pod->terminating &&
                world.now - view->pod->created > kStarting;
  }
  node.load = node.node->gpus > 0 ? load / node.node->gpus : load;
  node.silent =
      expected && world.now - newest > kExcluded && world.now - world.listening_since > kExcluded;
}

/// Links the objects of the world to each other.
class ViewBuilder {
 public:
  explicit ViewBuilder(const ClusterState& world) : world_(world) {}

  View build() && {
    view_.now = world_.now;
    add_nodes();
    add_fleets();
    add_workers();
    add_pods();
    add_telemetry();
    const auto workers_by_node = link_workers();
    assess_workers();
    for (std::size_t i = 0; i < view_.nodes.size(); ++i) {
      weigh(view_.nodes[i], workers_by_node[i], world_);
    }
    return std::move(view_);
  }

 private:
  using Index = std::unordered_map<std::string_view, std::size_t>;

  void add_nodes();
  void add_fleets();
  void add_workers();
  void add_pods();
  void add_telemetry();
  std::vector<std::vector<const WorkerView*>> link_workers();
  void assess_workers();

  NodeView* node_of(const std::string& name) {
    const auto found = nodes_.find(name);
    return found == nodes_.end() ? nullptr : &view_.nodes[found->second];
  }
  FleetView* fleet_of(const Worker& worker) {
    const auto found = fleets_.find(worker.fleet_uid);
    return found == fleets_.end() ? nullptr : &view_.fleets[found->second];
  }

  const ClusterState& world_;
  View view_;
  Index nodes_, workers_by_name_;
  Index fleets_, workers_by_uid_;
};

void ViewBuilder::add_nodes() {
  for (const Node* node : by_name(world_.nodes)) {
    nodes_.emplace(node->name, view_.nodes.size());
    view_.nodes.push_back({.node = node});
  }
}

void ViewBuilder::add_fleets() {
  for (const Fleet* fleet : by_name(world_.fleets)) {
    fleets_.emplace(fleet->uid, view_.fleets.size());
    view_.fleets.emplace_back().fleet = fleet;
  }
  for (const Demand& demand : world_.demand) {
    for (FleetView& fleet : view_.fleets) {
      if (fleet.fleet->name == demand.fleet) fleet.demand = &demand;
    }
  }
}

void ViewBuilder::add_workers() {
  view_.workers.reserve(world_.workers.size());
  for (const Worker* worker : by_name(world_.workers)) {
    workers_by_uid_.emplace(worker->uid, view_.workers.size());
    workers_by_name_.emplace(worker->name, view_.workers.size());
    view_.names.insert(worker->name);
    view_.workers.push_back({.worker = worker});
  }
}

void ViewBuilder::add_pods() {
  for (const Pod& pod : world_.pods) {
    view_.names.insert(pod.name);
    const auto owner = pod.owned ? workers_by_uid_.find(pod.owner_uid) : workers_by_uid_.end();
    // A pod with another name is not the worker's pod, whatever its owner reference says, but its
    // GPUs are in use.
    if (owner != workers_by_uid_.end() && view_.workers[owner->second].worker->name == pod.name) {
      view_.workers[owner->second].pod = &pod;
      continue;
    }
    if (const auto found = workers_by_name_.find(pod.name); found != workers_by_name_.end()) {
      view_.workers[found->second].name_conflict = &pod;
    }
    if (!pod.owned || pod.finished()) continue;
    if (NodeView* node = node_of(pod.node)) node->reserved += pod.gpus;
  }
}

void ViewBuilder::add_telemetry() {
  for (const Telemetry& sample : world_.telemetry) {
    const auto found = workers_by_uid_.find(sample.worker_uid);
    if (found == workers_by_uid_.end()) continue;
    WorkerView& worker = view_.workers[found->second];
    // Ignores delayed or repeated samples of an earlier pod of the worker.
    if (worker.pod ? sample.epoch != worker.pod->epoch || sample.sampled < worker.pod->created
                   : sample.epoch < worker.worker->status.epoch) {
      continue;
    }
    worker.telemetry = &sample;
    worker.heartbeat_fresh = world_.now - sample.sampled <= kHeartbeat;
  }
}

/// Links the workers to their nodes and fleets. Returns the workers of each node.
std::vector<std::vector<const WorkerView*>> ViewBuilder::link_workers() {
  std::vector<std::vector<const WorkerView*>> on(view_.nodes.size());
  for (WorkerView& worker : view_.workers) {
    if (NodeView* node = node_of(worker.worker->node)) {
      worker.node = node->node;
      node->reserved += worker.worker->gpus;
      on[static_cast<std::size_t>(node - view_.nodes.data())].push_back(&worker);
    }
    if (FleetView* fleet = fleet_of(*worker.worker)) {
      worker.fleet = fleet->fleet;
      fleet->workers.push_back(&worker);
    }
  }
  return on;
}

void ViewBuilder::assess_workers() {
  for (FleetView& fleet : view_.fleets) fleet.metrics_fresh = fresh(fleet, world_);
  for (WorkerView& worker : view_.workers) {
    const FleetView* fleet = fleet_of(*worker.worker);
    const bool metrics = !fleet || fleet->metrics_fresh;
    worker.heartbeat_age = silence(worker, world_);
    worker.heartbeat_overdue = metrics && worker.heartbeat_age > patience(worker, world_);
    worker.health = judge(worker, world_);
  }
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

View build_view(const ClusterState& world) { return ViewBuilder(world).build(); }

}  // namespace diaphane::fleet
