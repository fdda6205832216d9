#include <algorithm>
#include <cmath>

#include "operator/plan/parts.h"

namespace diaphane::fleet {
namespace {

constexpr Seconds kUnhealthyBeforeDrain = 60;
/// Longest pause for a worker whose pods fail repeatedly, and for a node that refuses workers.
constexpr Seconds kLongestPause = 300;
/// Grace period of a worker whose fleet was deleted first.
constexpr Seconds kDefaultGrace = 300;

/// Returns whether the status has reported this long enough to rule out a single odd read.
bool confirmed(const WorkerView& view, std::string_view type, ConditionStatus status, Seconds now) {
  const Condition* is = find(view.worker->status.conditions, type);
  return is && is->status == status && now - is->since >= kConfirmed;
}

/// Returns whether the worker no longer runs, whatever its pod's status says, because its node was
/// deleted or marked as out of service and it sends no heartbeat.
bool beyond_reach(const WorkerView& view, Seconds now) {
  if (view.heartbeat_fresh || !confirmed(view, "NodeLost", ConditionStatus::kTrue, now))
    return false;
  return view.node ? out_of_service(*view.node) : view.heartbeat_overdue;
}

/// Returns whether the pod has been neither listed nor sent telemetry for a while.
bool pod_gone(const WorkerView& view, PlanBuilder& builder) {
  if (view.pod) return false;
  const Worker& worker = *view.worker;
  Seconds since = worker.deleted.value_or(worker.created);
  if (const Condition* is = find(worker.status.conditions, "Scheduled")) {
    since = std::max(since, is->status == ConditionStatus::kUnknown ? is->since : builder.now);
  }
  if (view.telemetry) since = std::max(since, view.telemetry->sampled);
  builder.wake(since + kConfirmed);
  return builder.now >= since + kConfirmed;
}

/// Returns whether ending the worker interrupts no session: it does not run, or it has reported
/// after the start of its drain that it has no sessions, or the grace period is over.
bool may_end(const WorkerView& view, PlanBuilder& builder) {
  const Pod& pod = *view.pod;
  if (pod.finished() || beyond_reach(view, builder.now)) return true;
  const Drain& drain = *view.worker->drain;
  // The pod has not started. If that read was old, telemetry would have arrived by now.
  if (pod.phase == Phase::kPending && !view.telemetry && builder.now >= drain.since + kFresh) {
    return true;
  }
  const Seconds grace = view.fleet ? view.fleet->spec.drain_timeout : kDefaultGrace;
  if (builder.now >= drain.since + grace) return true;
  builder.wake(drain.since + grace);
  const Telemetry* sample = view.telemetry;
  return sample && sample->draining && sample->sampled > drain.since &&
         builder.now - sample->sampled <= kFresh && sample->sessions == 0 && sample->reserved == 0;
}

void end_pod(const WorkerView& view, PlanBuilder& builder) {
  if (!view.pod->terminating) builder.add(DeletePod{view.pod->name, view.pod->uid});
}

/// Handles a worker with a deletionTimestamp. Whatever the cause, its sessions get their grace
/// period.
void plan_deleted(const WorkerView& view, PlanBuilder& builder) {
  const Worker& worker = *view.worker;
  if (!view.pod) {
    if (pod_gone(view, builder) && worker.finalizer) {
      builder.add(RemoveFinalizer{Kind::kWorker, worker.name, worker.uid, worker.version});
    }
    return;
  }
  if (!worker.drain) return builder.drain(view, DrainReason::kDeleted);
  if (may_end(view, builder)) end_pod(view, builder);
}

void plan_drained(const WorkerView& view, PlanBuilder& builder) {
  const Worker& worker = *view.worker;
  if (view.pod && !may_end(view, builder)) return;
  builder.add(DeleteWorker{worker.name, worker.uid});
}

bool refusal_noted(const WorkerView& view) {
  const std::vector<NodeBackoff>& refusals = view.fleet->status.refusals;
  return std::any_of(refusals.begin(), refusals.end(), [&](const NodeBackoff& refusal) {
    return refusal.node == view.worker->node && refusal.since >= view.worker->created;
  });
}

DrainReason reason_named(std::string_view name) {
  for (const DrainReason reason :
       {DrainReason::kCordoned, DrainReason::kUpgrade, DrainReason::kIdle, DrainReason::kReplicas,
        DrainReason::kUnhealthy, DrainReason::kNodeLost, DrainReason::kFailing}) {
    if (name == to_string(reason)) return reason;
  }
  return DrainReason::kDeleted;
}

std::optional<DrainReason> why_drain(const WorkerView& view, PlanBuilder& builder) {
  const Worker& worker = *view.worker;
  // Restores a drain that was removed by hand.
  if (const Condition* draining = find(worker.status.conditions, "Draining");
      draining && draining->status == ConditionStatus::kTrue) {
    return reason_named(draining->reason);
  }
  if (view.fleet->deleted) return DrainReason::kDeleted;
  if (beyond_reach(view, builder.now)) return DrainReason::kNodeLost;
  if (view.node && view.node->cordoned) return DrainReason::kCordoned;
  if (worker.status.failures >= kMostFailures && refusal_noted(view)) return DrainReason::kFailing;
  if (view.health == Health::kUnhealthy) {
    if (view.heartbeat_age > kUnhealthyBeforeDrain) return DrainReason::kUnhealthy;
    builder.wake(builder.now + kUnhealthyBeforeDrain - view.heartbeat_age + 0.001);
  }
  return std::nullopt;
}

void make_pod(const WorkerView& view, PlanBuilder& builder) {
  const Worker& worker = *view.worker;
  if (view.heartbeat_fresh) return builder.wake(view.telemetry->sampled + kHeartbeat);
  if (view.name_conflict) {
    // A pod of an earlier worker of this name will disappear. A foreign pod stays, so the
    // reservation is useless.
    if (!view.name_conflict->owned) builder.add(DeleteWorker{worker.name, worker.uid});
    return;
  }
  if (worker.status.failures > 0) {
    const Seconds pause = std::min(kLongestPause, std::exp2(worker.status.failures - 1));
    if (builder.now < worker.status.failed_at + pause) {
      return builder.wake(worker.status.failed_at + pause);
    }
  }
  builder.add(CreatePod{worker.name, worker.uid, worker.node, worker.template_hash,
                        worker.status.epoch + 1, worker.gpus});
}

}  // namespace

void PlanBuilder::drain(const WorkerView& view, DrainReason reason) {
  if (view.worker->drain || !drained.insert(view.worker->uid).second) return;
  Seconds since = now;
  const Condition* draining = find(view.worker->status.conditions, "Draining");
  if (draining && draining->status == ConditionStatus::kTrue)
    since = std::min(since, draining->since);
  add(SetDrain{view.worker->name, view.worker->uid, view.worker->version, {reason, since}});
}

void plan_worker(const WorkerView& view, PlanBuilder& builder) {
  const Worker& worker = *view.worker;
  if (worker.deleted) return plan_deleted(view, builder);
  // A worker without its fleet is left to the garbage collector, which checks twice.
  if (!view.fleet) return;
  if (!worker.finalizer || !worker.labelled) {
    builder.add(Restore{Kind::kWorker, worker.name, worker.uid});
    if (!worker.finalizer) return;
  }
  if (view.pod && !view.pod->labelled && !view.pod->terminating) {
    builder.add(Restore{Kind::kPod, view.pod->name, view.pod->uid});
  }
  if (worker.drain) return plan_drained(view, builder);
  if (const auto reason = why_drain(view, builder)) return builder.drain(view, *reason);
  if (!view.pod) return make_pod(view, builder);
  if (view.pod->terminating) return;
  if (view.pod->finished()) {
    // The failure is counted before the pod is deleted, so that repeated failures get their pause.
    if (worker.status.failed_pod == view.pod->uid) return end_pod(view, builder);
    return;
  }
  if (view.pod->unschedulable && view.pod->node.empty() && refusal_noted(view)) {
    builder.add(DeleteWorker{worker.name, worker.uid});
  }
  if (view.heartbeat_fresh) builder.wake(view.telemetry->sampled + kHeartbeat + 0.001);
}

std::vector<NodeBackoff> refusals_of(const FleetView& fleet, Seconds now) {
  // A node without refusals for this long after its pause starts over.
  constexpr Seconds kForgotten = 120;
  constexpr std::size_t kMost = 256;
  std::vector<NodeBackoff> refusals;
  for (const NodeBackoff& refusal : fleet.fleet->status.refusals) {
    if (now < refusal.since + backoff_of(refusal) + kForgotten) refusals.push_back(refusal);
  }
  for (const WorkerView* view : fleet.workers) {
    const bool unschedulable = view->pod && view->pod->unschedulable && view->pod->node.empty();
    const bool failing = view->worker->status.failures >= kMostFailures;
    if ((!unschedulable && !failing) || view->leaving()) continue;
    const auto same = std::find_if(
        refusals.begin(), refusals.end(),
        [&](const NodeBackoff& refusal) { return refusal.node == view->worker->node; });
    if (same == refusals.end()) {
      refusals.push_back({view->worker->node, 1, now});
    } else if (same->since < view->worker->created) {
      *same = {view->worker->node, same->count + 1, now};
    }
  }
  const auto newer = [](const NodeBackoff& a, const NodeBackoff& b) {
    return a.since != b.since ? a.since > b.since : a.node < b.node;
  };
  std::sort(refusals.begin(), refusals.end(), newer);
  if (refusals.size() > kMost) refusals.resize(kMost);
  std::sort(refusals.begin(), refusals.end(),
            [](const NodeBackoff& a, const NodeBackoff& b) { return a.node < b.node; });
  return refusals;
}

Seconds backoff_of(const NodeBackoff& refusal) {
  return std::min(kLongestPause, 5 * std::exp2(std::max(refusal.count, 1) - 1));
}

std::string_view to_string(DrainReason reason) {
  switch (reason) {
    case DrainReason::kCordoned:
      return "Cordoned";
    case DrainReason::kUpgrade:
      return "Upgrade";
    case DrainReason::kDeleted:
      return "Deleted";
    case DrainReason::kIdle:
      return "Idle";
    case DrainReason::kReplicas:
      return "Replicas";
    case DrainReason::kUnhealthy:
      return "Unhealthy";
    case DrainReason::kNodeLost:
      return "NodeLost";
    case DrainReason::kFailing:
      return "Failing";
  }
  return "Deleted";
}

}  // namespace diaphane::fleet
