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

/// Whether the status has reported this for long enough that it is not a single odd read.
bool confirmed(const WorkerView& view, std::string_view type, Truth status, Seconds now) {
  const Condition* is = find(view.worker->status.conditions, type);
  return is && is->status == status && now - is->since >= kConfirmed;
}

/// Whether the worker no longer runs, whatever its pod's status says, because its node was deleted
/// or marked as out of service and it sends no heartbeat.
bool beyond_reach(const WorkerView& view, Seconds now) {
  if (view.beats || !confirmed(view, "NodeLost", Truth::kTrue, now)) return false;
  return view.node ? out_of_service(*view.node) : view.silence_counts;
}

/// Whether the pod has been neither listed nor sent telemetry for a while.
bool pod_gone(const WorkerView& view, Draft& draft) {
  if (view.pod) return false;
  const Worker& worker = *view.worker;
  Seconds since = worker.deleted.value_or(worker.created);
  if (const Condition* is = find(worker.status.conditions, "Scheduled")) {
    since = std::max(since, is->status == Truth::kUnknown ? is->since : draft.now);
  }
  if (view.telemetry) since = std::max(since, view.telemetry->sampled);
  draft.wake(since + kConfirmed);
  return draft.now >= since + kConfirmed;
}

/// Whether ending the worker interrupts no session: it does not run, or it has reported after the
/// start of its drain that it has no sessions, or the grace period is over.
bool may_end(const WorkerView& view, Draft& draft) {
  const Pod& pod = *view.pod;
  if (pod.finished() || beyond_reach(view, draft.now)) return true;
  const Drain& drain = *view.worker->drain;
  // The pod has not started. If that read was old, telemetry would have arrived by now.
  if (pod.phase == Phase::kPending && !view.telemetry && draft.now >= drain.since + kFresh) {
    return true;
  }
  const Seconds grace = view.fleet ? view.fleet->spec.drain_timeout : kDefaultGrace;
  if (draft.now >= drain.since + grace) return true;
  draft.wake(drain.since + grace);
  const Telemetry* sample = view.telemetry;
  return sample && sample->draining && sample->sampled > drain.since &&
         draft.now - sample->sampled <= kFresh && sample->sessions == 0 && sample->reserved == 0;
}

void end_pod(const WorkerView& view, Draft& draft) {
  if (!view.pod->terminating) draft.add(DeletePod{view.pod->name, view.pod->uid});
}

/// Handles a worker with a deletionTimestamp. Whatever the cause, its sessions get their grace
/// period.
void plan_deleted(const WorkerView& view, Draft& draft) {
  const Worker& worker = *view.worker;
  if (!view.pod) {
    if (pod_gone(view, draft) && worker.finalizer) {
      draft.add(RemoveFinalizer{Kind::kWorker, worker.name, worker.uid, worker.version});
    }
    return;
  }
  if (!worker.drain) return draft.drain(view, DrainReason::kDeleted);
  if (may_end(view, draft)) end_pod(view, draft);
}

void plan_drained(const WorkerView& view, Draft& draft) {
  const Worker& worker = *view.worker;
  if (view.pod && !may_end(view, draft)) return;
  draft.add(DeleteWorker{worker.name, worker.uid});
}

bool refusal_noted(const WorkerView& view) {
  const std::vector<Refusal>& refusals = view.fleet->status.refusals;
  return std::any_of(refusals.begin(), refusals.end(), [&](const Refusal& refusal) {
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

std::optional<DrainReason> why_drain(const WorkerView& view, Draft& draft) {
  const Worker& worker = *view.worker;
  // The drain was removed by hand and is restored.
  if (const Condition* draining = find(worker.status.conditions, "Draining");
      draining && draining->status == Truth::kTrue) {
    return reason_named(draining->reason);
  }
  if (view.fleet->deleted) return DrainReason::kDeleted;
  if (beyond_reach(view, draft.now)) return DrainReason::kNodeLost;
  if (view.node && view.node->cordoned) return DrainReason::kCordoned;
  if (worker.status.failures >= kMostFailures && refusal_noted(view)) return DrainReason::kFailing;
  if (view.health == Health::kUnhealthy) {
    if (view.silent > kUnhealthyBeforeDrain) return DrainReason::kUnhealthy;
    draft.wake(draft.now + kUnhealthyBeforeDrain - view.silent + 0.001);
  }
  return std::nullopt;
}

void make_pod(const WorkerView& view, Draft& draft) {
  const Worker& worker = *view.worker;
  if (view.beats) return draft.wake(view.telemetry->sampled + kHeartbeat);
  if (view.in_the_way) {
    // A pod of an earlier worker of this name will disappear. A foreign pod stays, so the
    // reservation is useless.
    if (!view.in_the_way->owned) draft.add(DeleteWorker{worker.name, worker.uid});
    return;
  }
  if (worker.status.failures > 0) {
    const Seconds pause = std::min(kLongestPause, std::exp2(worker.status.failures - 1));
    if (draft.now < worker.status.failed_at + pause) {
      return draft.wake(worker.status.failed_at + pause);
    }
  }
  draft.add(CreatePod{worker.name, worker.uid, worker.node, worker.template_hash,
                      worker.status.epoch + 1});
}

}  // namespace

void Draft::drain(const WorkerView& view, DrainReason reason) {
  if (view.worker->drain || !drained.insert(view.worker->uid).second) return;
  Seconds since = now;
  const Condition* draining = find(view.worker->status.conditions, "Draining");
  if (draining && draining->status == Truth::kTrue) since = std::min(since, draining->since);
  add(SetDrain{view.worker->name, view.worker->uid, view.worker->version, {reason, since}});
}

void plan_worker(const WorkerView& view, Draft& draft) {
  const Worker& worker = *view.worker;
  if (worker.deleted) return plan_deleted(view, draft);
  // Without its fleet, the worker waits for the garbage collector, which checks twice.
  if (!view.fleet) return;
  if (!worker.finalizer || !worker.labelled) {
    draft.add(Restore{Kind::kWorker, worker.name, worker.uid});
    if (!worker.finalizer) return;
  }
  if (view.pod && !view.pod->labelled && !view.pod->terminating) {
    draft.add(Restore{Kind::kPod, view.pod->name, view.pod->uid});
  }
  if (worker.drain) return plan_drained(view, draft);
  if (const auto reason = why_drain(view, draft)) return draft.drain(view, *reason);
  if (!view.pod) return make_pod(view, draft);
  if (view.pod->terminating) return;
  if (view.pod->finished()) {
    // The failure is counted before the pod is deleted, so that repeated failures get their pause.
    if (worker.status.failed_pod == view.pod->uid) return end_pod(view, draft);
    return;
  }
  if (view.pod->unschedulable && view.pod->node.empty() && refusal_noted(view)) {
    draft.add(DeleteWorker{worker.name, worker.uid});
  }
  if (view.beats) draft.wake(view.telemetry->sampled + kHeartbeat + 0.001);
}

std::vector<Refusal> refusals_of(const FleetView& fleet, Seconds now) {
  // A node without refusals for this long after its pause starts over.
  constexpr Seconds kForgotten = 120;
  constexpr std::size_t kMost = 256;
  std::vector<Refusal> refusals;
  for (const Refusal& refusal : fleet.fleet->status.refusals) {
    if (now < refusal.since + backoff_of(refusal) + kForgotten) refusals.push_back(refusal);
  }
  for (const WorkerView* view : fleet.workers) {
    const bool unschedulable = view->pod && view->pod->unschedulable && view->pod->node.empty();
    const bool failing = view->worker->status.failures >= kMostFailures;
    if ((!unschedulable && !failing) || view->leaving()) continue;
    const auto same = std::find_if(refusals.begin(), refusals.end(), [&](const Refusal& refusal) {
      return refusal.node == view->worker->node;
    });
    if (same == refusals.end()) {
      refusals.push_back({view->worker->node, 1, now});
    } else if (same->since < view->worker->created) {
      *same = {view->worker->node, same->count + 1, now};
    }
  }
  const auto newer = [](const Refusal& a, const Refusal& b) {
    return a.since != b.since ? a.since > b.since : a.node < b.node;
  };
  std::sort(refusals.begin(), refusals.end(), newer);
  if (refusals.size() > kMost) refusals.resize(kMost);
  std::sort(refusals.begin(), refusals.end(),
            [](const Refusal& a, const Refusal& b) { return a.node < b.node; });
  return refusals;
}

Seconds backoff_of(const Refusal& refusal) {
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
