#pragma once

#include <algorithm>
#include <set>
#include <string_view>
#include <vector>

#include "operator/plan/placing.h"
#include "operator/plan/plan.h"
#include "operator/plan/random.h"
#include "operator/plan/scale.h"
#include "operator/plan/view.h"

// The parts of a plan, in the order in which they run. Each adds to the builder.

namespace diaphane::fleet {

/// A plan under construction.
struct PlanBuilder {
  Plan plan;
  Seconds now = 0;
  std::set<std::string_view> drained;  ///< uids of workers that this plan drains

  void add(Action action) { plan.actions.push_back(std::move(action)); }
  /// Requests another plan at `due`. Ignores times in the past.
  void wake(Seconds due) {
    if (due <= now) return;
    const Seconds after = due - now;
    plan.requeue_after = std::min(plan.requeue_after.value_or(after), after);
  }
  void drain(const WorkerView& view, DrainReason reason);
  bool leaving(const WorkerView& view) const {
    return view.leaving() || drained.contains(view.worker->uid);
  }
};

/// The outcome of scaling, for the fleet's conditions.
struct Scaling {
  int desired = 0;
  int missing = 0;       ///< required workers for which no node has room
  int outdated = 0;      ///< workers with an earlier template that do not drain
  bool waiting = false;  ///< an outdated worker has sessions that cannot go elsewhere
  std::string why;       ///< why nodes were excluded
};

/// Plans one worker from its reservation to its end.
void plan_worker(const WorkerView& view, PlanBuilder& builder);
/// Plans the number of workers and their nodes. Reserves GPUs in `nodes`.
Scaling plan_scale(const FleetView& fleet, const View& world, std::vector<NodeView>& nodes,
                   Random& random, PlanBuilder& builder);
/// Returns the nodes that failed to run a worker of this fleet, including new ones.
std::vector<NodeBackoff> refusals_of(const FleetView& fleet, Seconds now);
void plan_worker_status(const WorkerView& view, PlanBuilder& builder);
void plan_fleet_status(const FleetView& fleet, const Scaling& scaling, PlanBuilder& builder);

/// Returns how long a node is avoided after its last refusal.
Seconds backoff_of(const NodeBackoff& refusal);
/// A worker is given up after this many failures of its pods.
inline constexpr int kMostFailures = 5;
inline constexpr Seconds kIdleBeforeDown = 60;

std::string_view to_string(DrainReason reason);
const Condition* find(const std::vector<Condition>& conditions, std::string_view type);

}  // namespace diaphane::fleet
