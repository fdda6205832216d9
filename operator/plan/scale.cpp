#include "operator/plan/scale.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "operator/plan/parts.h"

namespace diaphane::fleet {
namespace {

/// Returns how many outdated workers of a fleet may be replaced at the same time.
int surge_of(int desired) { return std::max(1, desired / 10); }

/// Returns whether a worker's slots count, because it accepts sessions or soon will.
bool counts(const WorkerView& view) {
  if (view.health == Health::kReady) return true;
  // A worker whose pods failed repeatedly may never start.
  return view.health == Health::kComing && view.worker->status.failures < 3;
}

int sessions_on(const WorkerView& view) {
  return view.telemetry ? view.telemetry->sessions + view.telemetry->reserved : 0;
}

/// Returns whether the worker has had no sessions for `since` seconds.
bool idle(const WorkerView& view, Seconds now, Seconds since) {
  const Telemetry* sample = view.telemetry;
  // A worker without a running pod is idle, unless a recent sample shows that one read was wrong.
  if (!view.pod || view.health == Health::kComing) {
    return !sample || now - sample->sampled > kFresh;
  }
  return view.heartbeat_fresh && sample->sessions == 0 && sample->reserved == 0 &&
         now - sample->idle_since >= since;
}

/// Sorts the workers to drain first to the front: those whose loss costs least.
void sort_to_drain(std::vector<const WorkerView*>& workers, const FleetSpec& spec,
                   const std::vector<NodeView>& nodes) {
  struct Key {
    bool current, started;
    int sessions;
    double node;
  };
  const auto key = [&](const WorkerView& view) {
    double node = 0;
    const auto found = std::lower_bound(
        nodes.begin(), nodes.end(), view.worker->node,
        [](const NodeView& a, const std::string& name) { return a.node->name < name; });
    if (found != nodes.end() && found->node->name == view.worker->node) {
      node = spec.strategy == Strategy::kPacked ? found->reserved : -found->load;
    }
    return Key{view.worker->template_hash == spec.template_hash, view.health == Health::kReady,
               sessions_on(view), node};
  };
  std::vector<std::pair<Key, const WorkerView*>> keyed;
  keyed.reserve(workers.size());
  for (const WorkerView* view : workers) keyed.emplace_back(key(*view), view);
  std::stable_sort(keyed.begin(), keyed.end(), [](const auto& a, const auto& b) {
    const Key &x = a.first, &y = b.first;
    return std::tie(x.started, x.sessions, x.current, x.node) <
           std::tie(y.started, y.sessions, y.current, y.node);
  });
  for (std::size_t i = 0; i < keyed.size(); ++i) workers[i] = keyed[i].second;
}

struct WorkerCounts {
  std::vector<const WorkerView*> active;  ///< not leaving
  int usable = 0;                         ///< of these, workers whose slots count
  int ready = 0;
  int outdated = 0;
  int upgrading = 0;  ///< leaving because of an outdated template
};

WorkerCounts tally(const FleetView& fleet, const PlanBuilder& builder) {
  WorkerCounts tally;
  for (const WorkerView* view : fleet.workers) {
    const Worker& worker = *view->worker;
    if (builder.leaving(*view)) {
      tally.upgrading += worker.drain && worker.drain->reason == DrainReason::kUpgrade;
      continue;
    }
    tally.active.push_back(view);
    tally.usable += counts(*view);
    tally.ready += view->health == Health::kReady;
    tally.outdated += worker.template_hash != fleet.fleet->spec.template_hash;
  }
  return tally;
}

/// Drains a worker, which then no longer counts as active.
void take(WorkerCounts& tally, std::size_t i, DrainReason reason, const FleetSpec& spec,
          PlanBuilder& builder) {
  const WorkerView& view = *tally.active[i];
  builder.drain(view, reason);
  tally.usable -= counts(view);
  tally.ready -= view.health == Health::kReady;
  if (view.worker->template_hash != spec.template_hash) {
    --tally.outdated;
    tally.upgrading += reason == DrainReason::kUpgrade;
  }
  tally.active.erase(tally.active.begin() + static_cast<std::ptrdiff_t>(i));
}

/// Drains outdated workers once others replace them, so that their sessions have somewhere to go.
void upgrade(const FleetView& fleet, int desired, bool room, WorkerCounts& tally, Scaling& scaling,
             PlanBuilder& builder) {
  const FleetSpec& spec = fleet.fleet->spec;
  int taken = fleet.demand ? fleet.demand->used + fleet.demand->reserved : 0, observed = 0;
  for (const WorkerView* view : fleet.workers) observed += sessions_on(*view);
  taken = std::max(taken, observed);
  for (std::size_t i = 0; i < tally.active.size();) {
    const WorkerView& view = *tally.active[i];
    if (view.worker->template_hash == spec.template_hash) {
      ++i;
      continue;
    }
    const bool started = view.health == Health::kReady;
    const bool never = view.health == Health::kComing;
    const bool replaced = tally.ready - started >= desired;
    // If no node has room for a surge, replaces one worker at a time, provided that the others have
    // enough slots.
    const bool alone = !room && tally.upgrading == 0 && fleet.metrics_fresh &&
                       (tally.ready - started) * spec.sessions_per_worker >= taken;
    if (tally.upgrading < surge_of(desired) && (replaced || alone || never)) {
      take(tally, i, DrainReason::kUpgrade, spec, builder);
      continue;
    }
    scaling.waiting |= !room;
    ++i;
  }
}

void scale_down(const FleetView& fleet, int most, WorkerCounts& tally, PlanBuilder& builder) {
  const FleetSpec& spec = fleet.fleet->spec;
  // An explicit number of replicas applies at once, without waiting for idle workers.
  const int bound = spec.replicas ? std::min(*spec.replicas, spec.max_replicas) : spec.max_replicas;
  for (std::size_t i = 0; i < tally.active.size();) {
    const WorkerView& view = *tally.active[i];
    if (bound == 0 || (counts(view) && tally.usable > bound)) {
      take(tally, i, DrainReason::kReplicas, spec, builder);
    } else if (tally.usable > most && counts(view) && idle(view, builder.now, kIdleBeforeDown)) {
      take(tally, i, DrainReason::kIdle, spec, builder);
    } else {
      if (tally.usable > most && view.telemetry) {
        builder.wake(view.telemetry->idle_since + kIdleBeforeDown);
      }
      ++i;
    }
  }
}

std::string name_of(const Fleet& fleet, int ordinal) {
  return fleet.name + "-" + std::to_string(ordinal);
}

void scale_up(const FleetView& fleet, const View& world, Placing& placing, int count,
              Random& random, Scaling& scaling, PlanBuilder& builder) {
  const FleetSpec& spec = fleet.fleet->spec;
  std::vector<Seconds> created;
  created.reserve(fleet.workers.size());
  for (const WorkerView* view : fleet.workers) created.push_back(view->worker->created);
  for (const NodeBackoff& refusal : fleet.fleet->status.refusals) created.push_back(refusal.since);
  Tokens tokens = refill_tokens(spec.max_refill_per_second, std::move(created), builder.now);
  int ordinal = 0;
  for (int i = 0; i < count; ++i) {
    if (tokens.count < 1) return builder.wake(tokens.next);
    const std::string* node = placing.next(spec.strategy, random);
    if (!node) {
      scaling.missing = count - i;
      scaling.why = placing.why();
      if (placing.again()) builder.wake(*placing.again());
      return;
    }
    while (world.names.contains(name_of(*fleet.fleet, ordinal))) ++ordinal;
    builder.add(CreateWorker{name_of(*fleet.fleet, ordinal), fleet.fleet->name, fleet.fleet->uid,
                             *node, spec.template_hash});
    ++ordinal;
    tokens.count -= 1;
  }
}

}  // namespace

DesiredReplicas desired_replicas(const FleetSpec& spec, const Demand* demand, int usable,
                                 Seconds now) {
  const auto bounded = [&](double count) {
    return static_cast<int>(std::clamp<double>(count, spec.min_replicas, spec.max_replicas));
  };
  if (spec.replicas) {
    const int fixed = std::clamp(*spec.replicas, 0, spec.max_replicas);
    return {fixed, fixed};
  }
  if (!demand || now - demand->sampled > kFresh) return {bounded(usable), bounded(usable)};
  const double busy = double(demand->used) + demand->reserved + demand->refused;
  if (busy == 0 && spec.scale_to_zero_after &&
      now - demand->last_used >= *spec.scale_to_zero_after) {
    return {bounded(0), bounded(0)};
  }
  // Keeps one spare slot, so that the last one is never handed out, and at least one worker unless
  // scale-to-zero applies.
  const double slots = busy + std::max(spec.min_idle_slots, 1);
  const double each = std::max(spec.sessions_per_worker, 1);
  return {bounded(std::ceil(slots / each)), bounded(std::ceil(slots * (1 + kHysteresis) / each))};
}

Tokens refill_tokens(double per_second, std::vector<Seconds> created, Seconds now) {
  if (!(per_second > 0)) return {1e9, now};
  std::sort(created.begin(), created.end());
  const double most = std::max(1.0, std::ceil(per_second));
  double count = most;
  Seconds last = created.empty() ? now : created.front();
  for (const Seconds at : created) {
    // A timestamp in the future comes from another clock.
    const Seconds when = std::min(at, now);
    count = std::min(most, count + (when - last) * per_second);
    count = std::max(0.0, count - 1);
    last = when;
  }
  count = std::min(most, count + (now - last) * per_second);
  // Rounding errors, for example of three thirds, must not prevent a whole token.
  if (count > 1 - 1e-6 && count < 1) count = 1;
  return {count, now + std::max(0.0, 1 - count) / per_second};
}

Scaling plan_scale(const FleetView& fleet, const View& world, std::vector<NodeView>& nodes,
                   Random& random, PlanBuilder& builder) {
  const FleetSpec& spec = fleet.fleet->spec;
  Scaling scaling;
  if (fleet.fleet->deleted) return scaling;
  WorkerCounts have = tally(fleet, builder);
  const DesiredReplicas desired = desired_replicas(spec, fleet.demand, have.usable, builder.now);
  scaling.desired = desired.least;
  sort_to_drain(have.active, spec, nodes);

  const std::vector<NodeBackoff> refusals = refusals_of(fleet, builder.now);
  Placing placing(*fleet.fleet, refusals, nodes, builder.now);
  const int surge = std::min(surge_of(desired.least), have.outdated);
  upgrade(fleet, desired.least, placing.room(), have, scaling, builder);
  scaling.outdated = have.outdated;
  if (have.outdated == 0 || desired.most == 0) scale_down(fleet, desired.most, have, builder);
  if (fleet.demand && spec.scale_to_zero_after && !spec.replicas && fleet.demand->used == 0) {
    const Seconds due = fleet.demand->last_used + *spec.scale_to_zero_after;
    if (due > builder.now) builder.wake(due);
  }
  // Lost workers may return, so they count until they are known to be gone.
  const int beside = spec.max_replicas + surge - static_cast<int>(have.active.size());
  const int short_of = std::min(desired.least + surge - have.usable, beside);
  if (short_of > 0) scale_up(fleet, world, placing, short_of, random, scaling, builder);
  // If there is no room for a surge, an upgrade replaces workers one by one.
  scaling.missing = std::min(scaling.missing, std::max(0, desired.least - have.usable));
  return scaling;
}

}  // namespace diaphane::fleet
