#pragma once

#include <unordered_map>

#include "operator/observe/objects.h"

namespace diaphane::fleet {

/// What the plan is made of, and what it does not need but whoever carries it out does.
struct Snapshot {
  World world;
  std::unordered_map<std::string, Template> pods_of;  ///< by uid of fleet or RenderWorker
  std::unordered_map<std::string, int> index;         ///< uid of a RenderWorker in world.workers
};

Snapshot snapshot_of(const std::vector<FleetObject>& fleets,
                     const std::vector<WorkerObject>& workers, const std::vector<PodObject>& pods,
                     const std::vector<NodeObject>& nodes, Seconds now);

}  // namespace diaphane::fleet
