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

// The parts of a plan, in the order in which they decide. Each adds to the draft.

namespace diaphane::fleet {

/// A plan that is being made.
struct Draft {
  Plan plan;
  Seconds now = 0;
  std::set<std::string_view> drained;  ///< workers' uids that this plan drains

  void add(Action action) { plan.actions.push_back(std::move(action)); }
  /// There will be something to do at `due`; what has passed is done with.
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

/// What scaling came to, for the fleet's conditions.
struct Scaling {
  int wanted = 0;
  int missing = 0;       ///< wanted, but no node has room for them
  int outdated = 0;      ///< of an earlier template, not draining
  bool waiting = false;  ///< an outdated one has sessions that have nowhere to go
  std::string why;       ///< nodes were left out
};

/// One worker from its reservation to its end.
void plan_worker(const WorkerView& view, Draft& draft);
/// How many workers, and where. `nodes` lose what is taken of them.
Scaling plan_scale(const FleetView& fleet, const View& world, std::vector<NodeView>& nodes,
                   Random& random, Draft& draft);
/// Nodes that were found not to take a worker of this fleet, this time included.
std::vector<Refusal> refusals_of(const FleetView& fleet, Seconds now);
void plan_worker_status(const WorkerView& view, Draft& draft);
void plan_fleet_status(const FleetView& fleet, const Scaling& scaling, Draft& draft);

/// After its last refusal a node is not asked for so long.
Seconds backoff_of(const Refusal& refusal);
/// So many failures of pods, and the worker is given up.
inline constexpr int kMostFailures = 5;
inline constexpr Seconds kIdleBeforeDown = 60;

std::string_view to_string(DrainReason reason);
const Condition* find(const std::vector<Condition>& conditions, std::string_view type);

}  // namespace diaphane::fleet
