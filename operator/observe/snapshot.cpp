#include "operator/observe/snapshot.h"

namespace diaphane::fleet {

Snapshot& Observer::snapshot(Seconds now) {
  ClusterState& world = snapshot_.world;
  world.now = now;
  const bool fleets = fleets_.newer(revisions_.fleets, [&](const auto& all) {
    world.fleets.clear();
    for (const auto& [uid, pods] : of_fleets_) snapshot_.pods_of.erase(uid);
    of_fleets_.clear();
    for (const auto& [name, one] : all) {
      world.fleets.push_back(one.fleet);
      of_fleets_.emplace(one.uid, one.pods);
    }
  });
  const bool workers = workers_.newer(revisions_.workers, [&](const auto& all) {
    world.workers.clear();
    world.workers.reserve(all.size());
    snapshot_.index.clear();
    snapshot_.pods_of.clear();
    for (const auto& [name, one] : all) {
      snapshot_.index.emplace(one.uid, static_cast<int>(world.workers.size()));
      snapshot_.pods_of.emplace(one.uid, one.pods);
      world.workers.push_back(one.worker);
    }
  });
  if (fleets || workers) {
    for (const auto& [uid, pods] : of_fleets_) snapshot_.pods_of.insert_or_assign(uid, pods);
  }
  const bool nodes = nodes_.newer(revisions_.nodes, [&](const auto& all) {
    world.nodes.clear();
    world.nodes.reserve(all.size());
    for (const auto& [name, one] : all) world.nodes.push_back(one.node);
  });
  const bool pods = pods_.newer(revisions_.pods, [&](const auto& all) {
    world.pods.clear();
    foreign_.clear();
    for (const auto& [name, one] : all) {
      if (one.ours) world.pods.push_back(one.pod);
      if (one.gpus > 0) foreign_[one.pod.node] += one.gpus;
    }
  });
  if (nodes || pods) weigh_foreign();
  return snapshot_;
}

void Observer::weigh_foreign() {
  for (Node& node : snapshot_.world.nodes) {
    const auto found = foreign_.find(node.name);
    node.foreign_gpus = found == foreign_.end() ? 0 : found->second;
  }
}

}  // namespace diaphane::fleet
