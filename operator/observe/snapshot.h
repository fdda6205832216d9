#pragma once

#include <unordered_map>

#include "operator/kube/store.h"
#include "operator/observe/objects.h"

namespace diaphane::fleet {

/// What the plan is made of, and what it does not need but whoever carries it out does.
struct Snapshot {
  World world;
  std::unordered_map<std::string, Template> pods_of;  ///< by uid of fleet or RenderWorker
  std::unordered_map<std::string, int> index;         ///< uid of a RenderWorker in world.workers
};

/// A snapshot that is brought up to date by the kinds that changed: of thousands of workers none is
/// copied while nothing happens. Of one thread; the stores outlive it.
class Observer {
 public:
  Observer(const kube::Store<FleetObject>& fleets, const kube::Store<WorkerObject>& workers,
           const kube::Store<PodObject>& pods, const kube::Store<NodeObject>& nodes)
      : fleets_(fleets), workers_(workers), pods_(pods), nodes_(nodes) {}

  /// As it is now. What is of Redis in its world is left as it was.
  Snapshot& look(Seconds now);

 private:
  void weigh_foreign();

  const kube::Store<FleetObject>& fleets_;
  const kube::Store<WorkerObject>& workers_;
  const kube::Store<PodObject>& pods_;
  const kube::Store<NodeObject>& nodes_;
  struct Seen {
    std::uint64_t fleets = 0, workers = 0, pods = 0, nodes = 0;  ///< revisions
  } seen_;
  std::unordered_map<std::string, Template> of_fleets_;  ///< their part of pods_of
  std::unordered_map<std::string, int> foreign_;  ///< GPUs of pods that are not ours, by node
  Snapshot snapshot_;
};

}  // namespace diaphane::fleet
