#include "operator/plan/plan.h"

#include <algorithm>

#include "operator/plan/parts.h"

namespace diaphane::fleet {
namespace {

/// Seconds until the next plan without any change, because ages grow unobserved.
constexpr Seconds kLookAgain = 3;

void plan_fleet(const FleetView& view, PlanBuilder& builder) {
  const Fleet& fleet = *view.fleet;
  if (fleet.deleted) {
    if (fleet.finalizer && view.workers.empty()) {
      builder.add(RemoveFinalizer{Kind::kFleet, fleet.name, fleet.uid, fleet.version});
    }
  } else if (!fleet.finalizer) {
    builder.add(Restore{Kind::kFleet, fleet.name, fleet.uid});
  }
}

}  // namespace

Plan plan(const ClusterState& world, std::uint64_t seed) {
  PlanBuilder builder;
  builder.now = world.now;
  if (!world.complete) return {};
  View view = build_view(world);
  Random random(seed);
  for (const WorkerView& worker : view.workers) plan_worker(worker, builder);
  for (const FleetView& fleet : view.fleets) {
    plan_fleet(fleet, builder);
    const Scaling scaling = plan_scale(fleet, view, view.nodes, random, builder);
    plan_fleet_status(fleet, scaling, builder);
  }
  for (const WorkerView& worker : view.workers) {
    if (worker.fleet) plan_worker_status(worker, builder);
  }
  if (!world.fleets.empty() || !world.workers.empty()) builder.wake(world.now + kLookAgain);
  // Sorts by the order of Action, in which actions that release something precede those that
  // reserve.
  std::stable_sort(builder.plan.actions.begin(), builder.plan.actions.end(),
                   [](const Action& a, const Action& b) { return a.index() < b.index(); });
  return std::move(builder.plan);
}

}  // namespace diaphane::fleet
