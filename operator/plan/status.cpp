#include <algorithm>
#include <tuple>

#include "operator/plan/parts.h"

namespace diaphane::fleet {
namespace {

/// Minimum seconds between two writes of a fleet's numbers.
constexpr Seconds kBetweenWrites = 1;
/// The failures of a worker are forgotten after it was ready for this long.
constexpr Seconds kForgiven = 120;

/// Keeps the transition time of `before` if the status is unchanged.
Condition condition(const std::vector<Condition>& before, std::string type, ConditionStatus status,
                    std::string reason, std::string message, Seconds now) {
  const Condition* same = find(before, type);
  const Seconds since = same && same->status == status ? same->since : now;
  return {std::move(type), status, std::move(reason), std::move(message), since};
}

ConditionStatus status_of(bool holds) {
  return holds ? ConditionStatus::kTrue : ConditionStatus::kFalse;
}

bool same_status(const FleetStatus& a, const FleetStatus& b) {
  const auto all = [](const FleetStatus& s) {
    return std::tie(s.observed_generation, s.replicas, s.ready_replicas, s.slots_total,
                    s.slots_used, s.slots_reserved, s.refusals, s.conditions);
  };
  return all(a) == all(b);
}

struct Counts {
  int active = 0, ready = 0, coming = 0, leaving = 0, sick = 0;
};

Counts count(const FleetView& fleet) {
  Counts counts;
  for (const WorkerView* view : fleet.workers) {
    if (view->leaving()) {
      ++counts.leaving;
      continue;
    }
    ++counts.active;
    counts.ready += view->health == Health::kReady;
    counts.coming += view->health == Health::kComing;
    counts.sick += view->health == Health::kUnhealthy || view->health == Health::kNodeLost ||
                   view->worker->status.failures > 0;
  }
  return counts;
}

std::vector<Condition> conditions_of(const FleetView& fleet, const Scaling& scaling,
                                     const Counts& counts, Seconds now) {
  const std::vector<Condition>& before = fleet.fleet->status.conditions;
  std::vector<Condition> all;
  const auto add = [&](const char* type, bool holds, std::string reason, std::string message) {
    all.push_back(
        condition(before, type, status_of(holds), std::move(reason), std::move(message), now));
  };
  const std::string of = std::to_string(counts.ready) + " of " + std::to_string(scaling.desired);
  const bool available = counts.ready > 0 || scaling.desired == 0;
  add("Available", available, available ? "WorkersReady" : "NoWorkersReady",
      of + " workers are ready");
  std::string progress = "Settled";
  if (fleet.fleet->deleted) {
    progress = "Deleting";
  } else if (scaling.outdated > 0) {
    progress = scaling.waiting ? "WaitingForCapacity" : "Upgrading";
  } else if (counts.leaving > 0) {
    progress = "Draining";
  } else if (counts.coming > 0 || scaling.missing > 0 || counts.ready < scaling.desired) {
    progress = "Scaling";
  }
  add("Progressing", progress != "Settled", progress, "");
  add("Degraded", counts.sick > 0, counts.sick > 0 ? "WorkersFailing" : "AsExpected",
      counts.sick > 0 ? "Workers that are lost or unresponsive, or that failed recently: " +
                            std::to_string(counts.sick)
                      : "");
  const bool asked = fleet.demand && now - fleet.demand->sampled <= kFresh;
  const bool metrics = fleet.metrics_fresh && asked;
  add("MetricsFresh", metrics,
      metrics               ? "Fresh"
      : fleet.metrics_fresh ? "NoDemand"
                            : "NoTelemetry",
      metrics ? "" : "No worker is removed until the metrics are fresh again");
  add("CapacityLimited", scaling.missing > 0,
      scaling.missing > 0 ? "InsufficientNodeCapacity" : "SufficientCapacity",
      scaling.missing > 0
          ? "Missing workers: " + std::to_string(scaling.missing) + ". " + scaling.why
          : "");
  return all;
}

std::string ready_reason(const WorkerView& view) {
  if (view.leaving()) return "Draining";
  switch (view.health) {
    case Health::kReady:
      return "AcceptingSessions";
    case Health::kUnhealthy:
      return "NoHeartbeat";
    case Health::kNodeLost:
      return "NodeUnreachable";
    case Health::kComing:
      break;
  }
  return "Starting";
}

}  // namespace

const Condition* find(const std::vector<Condition>& conditions, std::string_view type) {
  for (const Condition& one : conditions) {
    if (one.type == type) return &one;
  }
  return nullptr;
}

void plan_worker_status(const WorkerView& view, PlanBuilder& builder) {
  const Worker& worker = *view.worker;
  WorkerStatus status = worker.status;
  const Seconds now = builder.now;
  const Pod* pod = view.pod;
  if (pod && (pod->phase == Phase::kFailed || pod->phase == Phase::kSucceeded) &&
      status.failed_pod != pod->uid) {
    ++status.failures;
    status.failed_pod = pod->uid;
    status.failed_at = now;
  } else if (status.failures > 0 && view.health == Health::kReady && pod &&
             now - std::max(status.failed_at, pod->created) > kForgiven) {
    status.failures = 0;
  }
  if (pod) status.epoch = std::max(status.epoch, pod->epoch);
  status.observed_generation = worker.generation;
  status.conditions.clear();
  const auto add = [&](const char* type, bool holds, std::string reason) {
    status.conditions.push_back(
        condition(worker.status.conditions, type, status_of(holds), std::move(reason), "", now));
  };
  // Unknown while there is no pod. The release of a worker waits for this condition.
  const bool bound = view.heartbeat_fresh || (pod && !pod->node.empty());
  status.conditions.push_back(
      condition(worker.status.conditions, "Scheduled",
                !pod && !bound ? ConditionStatus::kUnknown : status_of(bound),
                bound                ? "Bound"
                : !pod               ? "NoPod"
                : pod->unschedulable ? "Unschedulable"
                                     : "Waiting",
                "", now));
  const bool ready = view.health == Health::kReady && !view.leaving();
  add("Ready", ready, ready_reason(view));
  // If someone removed the drain by hand, the condition still shows it until it is restored.
  const Condition* draining = find(worker.status.conditions, "Draining");
  const bool was = draining && draining->status == ConditionStatus::kTrue;
  add("Draining", worker.drain || was,
      worker.drain ? std::string(to_string(worker.drain->reason))
      : was        ? draining->reason
                   : "Active");
  add("Unhealthy", view.health == Health::kUnhealthy,
      view.health == Health::kUnhealthy ? "NoHeartbeat" : "HeartbeatReceived");
  add("NodeLost", view.health == Health::kNodeLost,
      view.health == Health::kNodeLost ? "NodeUnreachable" : "NodeReachable");
  if (status != worker.status) builder.add(SetWorkerStatus{worker.name, worker.uid, status});
}

void plan_fleet_status(const FleetView& fleet, const Scaling& scaling, PlanBuilder& builder) {
  const FleetStatus& before = fleet.fleet->status;
  const Counts counts = count(fleet);
  FleetStatus status = before;
  status.observed_generation = fleet.fleet->generation;
  status.replicas = counts.active;
  status.ready_replicas = counts.ready;
  status.slots_total = counts.ready * fleet.fleet->spec.sessions_per_worker;
  if (fleet.demand) {
    status.slots_used = fleet.demand->used;
    status.slots_reserved = fleet.demand->reserved;
  }
  status.refusals = refusals_of(fleet, builder.now);
  status.conditions = conditions_of(fleet, scaling, counts, builder.now);
  if (same_status(status, before)) return;
  // The plan waits for refusals, and clients for the observed generation, so both are written at
  // once.
  const bool urgent = status.refusals != before.refusals ||
                      status.observed_generation != before.observed_generation;
  if (!urgent && builder.now - before.written < kBetweenWrites) {
    return builder.wake(before.written + kBetweenWrites);
  }
  status.written = builder.now;
  builder.add(SetFleetStatus{fleet.fleet->name, fleet.fleet->uid, status});
}

}  // namespace diaphane::fleet
