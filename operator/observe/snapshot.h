#pragma once

#include <unordered_map>

#include "operator/kube/store.h"
#include "operator/observe/objects.h"

namespace diaphane::fleet {

/// The input of the plan, and the data that only the execution of its actions needs.
struct Snapshot {
  ClusterState world;
  std::unordered_map<std::string, Template> pods_of;  ///< key: uid of the fleet or RenderWorker
  std::unordered_map<std::string, int> index;  ///< index in world.workers by uid of a RenderWorker
};

/// Keeps a snapshot current by updating only the kinds that changed, so that thousands of workers
/// are not copied when nothing happens. Not thread-safe. The stores must outlive it.
class Observer {
 public:
  Observer(const kube::Store<FleetObject>& fleets, const kube::Store<WorkerObject>& workers,
           const kube::Store<PodObject>& pods, const kube::Store<NodeObject>& nodes)
      : fleets_(fleets), workers_(workers), pods_(pods), nodes_(nodes) {}

  /// Returns the current state. Leaves the data from Redis unchanged.
  Snapshot& snapshot(Seconds now);

 private:
  void weigh_foreign();

  const kube::Store<FleetObject>& fleets_;
  const kube::Store<WorkerObject>& workers_;
  const kube::Store<PodObject>& pods_;
  const kube::Store<NodeObject>& nodes_;
  struct Seen {
    std::uint64_t fleets = 0, workers = 0, pods = 0, nodes = 0;  ///< revisions of the stores
  } revisions_;
  std::unordered_map<std::string, Template> of_fleets_;  ///< the fleets' entries of pods_of
  /// GPUs of pods that no RenderWorker owns, by node.
  std::unordered_map<std::string, int> foreign_;
  Snapshot snapshot_;
};

}  // namespace diaphane::fleet
