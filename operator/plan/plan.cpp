#include "operator/plan/plan.h"

#include <algorithm>

#include "operator/plan/parts.h"

namespace diaphane::fleet {
namespace {

/// Seconds until the next plan without any change, because ages grow unobserved.
constexpr Seconds kLookAgain = 3;

void plan_fleet(const FleetView& view, Draft& draft) {
  const Fleet& fleet = *view.fleet;
  if (fleet.deleted) {
    if (fleet.finalizer && view.workers.empty()) {
      draft.add(RemoveFinalizer{Kind::kFleet, fleet.name, fleet.uid, fleet.version});
    }
  } else if (!fleet.finalizer) {
    draft.add(Restore{Kind::kFleet, fleet.name, fleet.uid});
  }
}

}  // namespace

Plan plan(const World& world, std::uint64_t seed) {
  Draft draft;
  draft.now = world.now;
  if (!world.complete) return {};
  View view = look(world);
  Random random(seed);
  for (const WorkerView& worker : view.workers) plan_worker(worker, draft);
  for (const FleetView& fleet : view.fleets) {
    plan_fleet(fleet, draft);
    const Scaling scaling = plan_scale(fleet, view, view.nodes, random, draft);
    plan_fleet_status(fleet, scaling, draft);
  }
  for (const WorkerView& worker : view.workers) {
    if (worker.fleet) plan_worker_status(worker, draft);
  }
  if (!world.fleets.empty() || !world.workers.empty()) draft.wake(world.now + kLookAgain);
  // Actions that release or record something come before actions that reserve.
  std::stable_sort(draft.plan.actions.begin(), draft.plan.actions.end(),
                   [](const Action& a, const Action& b) { return a.index() < b.index(); });
  return std::move(draft.plan);
}

}  // namespace diaphane::fleet
