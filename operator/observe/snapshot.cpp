#include "operator/observe/snapshot.h"

namespace diaphane::fleet {

Snapshot snapshot_of(const std::vector<FleetObject>& fleets,
                     const std::vector<WorkerObject>& workers, const std::vector<PodObject>& pods,
                     const std::vector<NodeObject>& nodes, Seconds now) {
  Snapshot snapshot;
  World& world = snapshot.world;
  world.now = now;
  for (const FleetObject& one : fleets) {
    world.fleets.push_back(one.fleet);
    snapshot.pods_of.emplace(one.uid, one.pods);
  }
  for (const WorkerObject& one : workers) {
    snapshot.index.emplace(one.uid, static_cast<int>(world.workers.size()));
    world.workers.push_back(one.worker);
    snapshot.pods_of.emplace(one.uid, one.pods);
  }
  std::unordered_map<std::string_view, Node*> by_name;
  world.nodes.reserve(nodes.size());
  for (const NodeObject& one : nodes) {
    world.nodes.push_back(one.node);
    by_name.emplace(one.node.name, &world.nodes.back());
  }
  for (const PodObject& one : pods) {
    if (one.ours) world.pods.push_back(one.pod);
    if (one.gpus == 0) continue;
    const auto at = by_name.find(one.pod.node);
    if (at != by_name.end()) at->second->foreign_gpus += one.gpus;
  }
  return snapshot;
}

}  // namespace diaphane::fleet
