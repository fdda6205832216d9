#include "tests/support/operator/simulated_cluster.h"

#include <algorithm>

namespace diaphane::fleet {
namespace {

template <typename T, typename Match>
T* find_if(std::vector<T>& all, const Match& match) {
  const auto found = std::find_if(all.begin(), all.end(), match);
  return found == all.end() ? nullptr : &*found;
}

void bump(std::string& version) { version = std::to_string(std::stoll("0" + version) + 1); }

}  // namespace

ClusterState SimulatedCluster::observed() const {
  ClusterState world = world_;
  world.complete = true;
  return world;
}

bool SimulatedCluster::apply(const Action& action) {
  return std::visit([&](const auto& one) { return carry_out(one); }, action);
}

Fleet& SimulatedCluster::add_fleet(const std::string& name) {
  Fleet fleet;
  fleet.name = name;
  fleet.uid = fresh("fleet-");
  fleet.version = "1";
  fleet.spec.template_hash = "one";
  world_.fleets.push_back(fleet);
  last_used_[name] = world_.now;
  return world_.fleets.back();
}

Node& SimulatedCluster::add_node(const std::string& name, int gpus) {
  Node node;
  node.name = name;
  node.gpus = gpus;
  world_.nodes.push_back(node);
  return world_.nodes.back();
}

Worker* SimulatedCluster::worker(const std::string& name, const std::string& uid) {
  return find_if(world_.workers, [&](const Worker& w) { return w.name == name && w.uid == uid; });
}
Worker* SimulatedCluster::worker_of(const std::string& uid) {
  return find_if(world_.workers, [&](const Worker& w) { return w.uid == uid; });
}
Pod* SimulatedCluster::pod(const std::string& name, const std::string& uid) {
  return find_if(world_.pods, [&](const Pod& p) { return p.name == name && p.uid == uid; });
}
Fleet* SimulatedCluster::fleet(const std::string& name, const std::string& uid) {
  return find_if(world_.fleets, [&](const Fleet& f) { return f.name == name && f.uid == uid; });
}
Node* SimulatedCluster::node(const std::string& name) {
  return find_if(world_.nodes, [&](const Node& n) { return n.name == name; });
}

bool SimulatedCluster::carry_out(const CreateWorker& action) {
  for (const Worker& one : world_.workers) {
    if (one.name == action.name) return false;
  }
  Worker made;
  made.name = action.name;
  made.uid = fresh("worker-");
  made.version = "1";
  made.fleet = action.fleet;
  made.fleet_uid = action.fleet_uid;
  made.node = action.node;
  made.template_hash = action.template_hash;
  if (const Fleet* of = fleet(action.fleet, action.fleet_uid)) made.gpus = of->spec.gpus_per_worker;
  made.created = world_.now;
  world_.workers.push_back(made);
  return true;
}

bool SimulatedCluster::carry_out(const CreatePod& action) {
  Worker* owner = worker(action.worker, action.worker_uid);
  if (!owner) return false;
  for (const Pod& one : world_.pods) {
    if (one.name == action.worker) return false;
  }
  Pod made;
  made.name = action.worker;
  made.uid = fresh("pod-");
  made.owned = true;
  made.owner_uid = action.worker_uid;
  made.epoch = action.epoch;
  made.gpus = action.gpus;
  made.created = world_.now;
  world_.pods.push_back(made);
  return true;
}

bool SimulatedCluster::carry_out(const SetDrain& action) {
  Worker* drained = worker(action.worker, action.uid);
  if (!drained || drained->version != action.version) return false;
  // The decision's sample must have contained any older session. (A paused operator may execute the
  // drain late, and newer sessions then move within their grace period.)
  for (const Session& session : sessions_) {
    if (action.drain.reason == DrainReason::kIdle && session.worker_uid == action.uid &&
        session.placed < action.drain.since - 5) {
      violations_.push_back("drained a worker with a session as idle: " + action.worker);
    }
  }
  drained->drain = action.drain;
  bump(drained->version);
  ++drained->generation;
  return true;
}

bool SimulatedCluster::carry_out(const DeletePod& action) {
  Pod* deleted = pod(action.name, action.uid);
  if (!deleted) return false;
  if (!deleted->owned) violations_.push_back("deleted a pod of another owner: " + action.name);
  const Worker* owner = worker_of(deleted->owner_uid);
  if (deleted->phase == Phase::kRunning && alive(deleted->node) &&
      sessions_on(deleted->owner_uid) > 0) {
    Seconds grace = 300;
    if (owner) {
      if (const Fleet* of = fleet(owner->fleet, owner->fleet_uid)) grace = of->spec.drain_timeout;
    }
    if (!owner || !owner->drain || world_.now < owner->drain->since + grace) {
      violations_.push_back("ended a pod with sessions during their grace period: " + action.name);
    }
  }
  if (deleted->node.empty()) {
    drop_pod(action.uid);
  } else if (!deleted->terminating) {
    deleted->terminating = world_.now;
  }
  return true;
}

bool SimulatedCluster::carry_out(const DeleteWorker& action) {
  Worker* deleted = worker(action.name, action.uid);
  if (!deleted) return false;
  if (!deleted->finalizer) {
    std::erase_if(world_.workers, [&](const Worker& w) { return w.uid == action.uid; });
  } else if (!deleted->deleted) {
    deleted->deleted = world_.now;
    bump(deleted->version);
  }
  return true;
}

bool SimulatedCluster::carry_out(const RemoveFinalizer& action) {
  if (action.kind == Kind::kFleet) {
    Fleet* of = fleet(action.name, action.uid);
    if (!of || of->version != action.version) return false;
    of->finalizer = false;
    if (of->deleted) {
      std::erase_if(world_.fleets, [&](const Fleet& f) { return f.uid == action.uid; });
    }
    return true;
  }
  Worker* of = worker(action.name, action.uid);
  if (!of || of->version != action.version) return false;
  for (const Pod& one : world_.pods) {
    if (one.owner_uid == of->uid && one.name == of->name && alive(one.node)) {
      violations_.push_back("removed a reservation before its pod was gone: " + of->name);
    }
  }
  of->finalizer = false;
  bump(of->version);
  if (of->deleted) {
    std::erase_if(world_.workers, [&](const Worker& w) { return w.uid == action.uid; });
  }
  return true;
}

bool SimulatedCluster::carry_out(const Restore& action) {
  if (action.kind == Kind::kFleet) {
    Fleet* of = fleet(action.name, action.uid);
    if (of) of->finalizer = true;
    return of != nullptr;
  }
  if (action.kind == Kind::kPod) {
    Pod* of = pod(action.name, action.uid);
    if (of && !of->owned) violations_.push_back("edited a pod of another owner: " + of->name);
    if (of) of->labelled = true;
    return of != nullptr;
  }
  Worker* of = worker(action.name, action.uid);
  if (!of) return false;
  of->finalizer = of->labelled = true;
  bump(of->version);
  return true;
}

bool SimulatedCluster::carry_out(const SetWorkerStatus& action) {
  Worker* of = worker(action.name, action.uid);
  if (!of) return false;
  of->status = action.status;
  bump(of->version);
  return true;
}

bool SimulatedCluster::carry_out(const SetFleetStatus& action) {
  Fleet* of = fleet(action.name, action.uid);
  if (!of) return false;
  of->status = action.status;
  bump(of->version);
  return true;
}

bool SimulatedCluster::alive(const std::string& node_name) {
  return node(node_name) != nullptr && !lost_[node_name];
}

void SimulatedCluster::end_sessions(const std::string& worker_uid) {
  std::erase_if(sessions_, [&](const Session& s) { return s.worker_uid == worker_uid; });
}

void SimulatedCluster::drop_pod(const std::string& uid) {
  const Pod* gone = find_if(world_.pods, [&](const Pod& p) { return p.uid == uid; });
  if (!gone) return;
  end_sessions(gone->owner_uid);
  std::erase_if(world_.pods, [&](const Pod& p) { return p.uid == uid; });
}

void SimulatedCluster::crash_pod(const std::string& name) {
  for (Pod& one : world_.pods) {
    if (one.name != name || !one.owned || one.phase != Phase::kRunning) continue;
    one.phase = Phase::kFailed;
    one.ready = false;
    end_sessions(one.owner_uid);
  }
}

void SimulatedCluster::lose_node(const std::string& name) {
  lost_[name] = true;
  if (Node* one = node(name)) one->ready = false;
}

void SimulatedCluster::return_node(const std::string& name) {
  lost_[name] = false;
  if (Node* one = node(name)) one->ready = true;
}

void SimulatedCluster::delete_node(const std::string& name) {
  std::erase_if(world_.nodes, [&](const Node& n) { return n.name == name; });
}

void SimulatedCluster::hang(const std::string& name, bool hangs) {
  for (const Worker& one : world_.workers) {
    if (one.name == name) hangs_[one.uid] = hangs;
  }
}

void SimulatedCluster::refuse(const std::string& name, bool refuses) { refuses_[name] = refuses; }

int SimulatedCluster::sessions_on(const std::string& worker_uid) const {
  return static_cast<int>(std::count_if(sessions_.begin(), sessions_.end(), [&](const Session& s) {
    return s.worker_uid == worker_uid;
  }));
}

int SimulatedCluster::sessions_of(const std::string& name) const {
  return static_cast<int>(std::count_if(sessions_.begin(), sessions_.end(),
                                        [&](const Session& s) { return s.fleet == name; }));
}

int SimulatedCluster::waiting(const std::string& name) const {
  const auto found = people_.find(name);
  return found == people_.end() ? 0 : std::max(0, found->second - sessions_of(name));
}

int SimulatedCluster::gpus_on(const std::string& name) const {
  int gpus = 0;
  for (const Pod& pod : world_.pods) {
    if (pod.node == name && !pod.finished() && pod.owned) gpus += pod.gpus;
  }
  return gpus;
}

void SimulatedCluster::collect_garbage() {
  for (Worker& one : world_.workers) {
    if (!one.deleted && !fleet(one.fleet, one.fleet_uid)) {
      one.deleted = world_.now;
      bump(one.version);
    }
  }
  std::erase_if(world_.workers, [](const Worker& w) { return w.deleted && !w.finalizer; });
  std::vector<std::string> gone;
  for (Pod& one : world_.pods) {
    const bool orphan = one.owned && !worker_of(one.owner_uid);
    const Node* at = node(one.node);
    const bool marked = at && !at->taints.empty() && one.terminating;  // out of service
    const bool no_node = !one.node.empty() && (!at || marked);
    if (no_node || (orphan && one.node.empty())) gone.push_back(one.uid);
    if (orphan && !one.terminating) one.terminating = world_.now;
  }
  for (const std::string& uid : gone) drop_pod(uid);
}

void SimulatedCluster::schedule() {
  for (Pod& one : world_.pods) {
    if (!one.owned || !one.node.empty() || one.terminating) continue;
    const Worker* owner = worker_of(one.owner_uid);
    const Node* at = owner ? node(owner->node) : nullptr;
    const bool fits = at && at->ready && !at->cordoned && !refuses_[at->name] &&
                      gpus_on(at->name) + one.gpus + at->foreign_gpus <= at->gpus;
    if (fits) {
      one.node = at->name;
      one.unschedulable.reset();
      one.created = world_.now;
    } else if (!one.unschedulable) {
      one.unschedulable = world_.now;
    }
  }
}

void SimulatedCluster::run_kubelets() {
  std::vector<std::string> gone;
  for (Pod& one : world_.pods) {
    if (one.node.empty() || !alive(one.node)) continue;
    if (one.terminating) {
      if (one.finished() || chance(0.5)) gone.push_back(one.uid);
      continue;
    }
    if (one.phase == Phase::kPending && chance(0.5)) one.phase = Phase::kRunning;
    if (one.phase == Phase::kRunning && !one.ready && chance(0.5)) one.ready = true;
  }
  for (const std::string& uid : gone) drop_pod(uid);
}

bool SimulatedCluster::takes_sessions(const Worker& one) {
  const Pod* its = find_if(
      world_.pods, [&](const Pod& p) { return p.owner_uid == one.uid && p.name == one.name; });
  return its && its->ready && its->phase == Phase::kRunning && !its->terminating &&
         alive(its->node) && !drain_orders_.contains(one.uid) && !hangs_[one.uid];
}

void SimulatedCluster::run_sessions() {
  std::map<std::string, int> slots;
  for (const Fleet& of : world_.fleets) slots[of.name] = of.spec.sessions_per_worker;
  // renderd notices its drain the next time it reads its resource.
  for (const Worker& one : world_.workers) {
    if (one.drain && chance(0.7)) drain_orders_.emplace(one.uid, world_.now);
  }
  std::erase_if(sessions_, [&](const Session& s) {
    const Worker* at = worker_of(s.worker_uid);
    const Pod* its =
        find_if(world_.pods, [&](const Pod& p) { return p.owner_uid == s.worker_uid; });
    return !at || !its || !alive(its->node) || hangs_[s.worker_uid];
  });
  std::map<std::string, int> taken;
  for (const Session& session : sessions_) ++taken[session.worker_uid];
  const auto place = [&](const std::string& of) -> const Worker* {
    const Worker* best = nullptr;
    for (const Worker& one : world_.workers) {
      if (one.fleet != of || !takes_sessions(one) || taken[one.uid] >= slots[of]) continue;
      if (!best || taken[one.uid] < taken[best->uid]) best = &one;
    }
    return silent_ ? nullptr : best;
  };
  // Sessions of a draining worker are placed again where there is room.
  for (Session& session : sessions_) {
    if (!drain_orders_.contains(session.worker_uid) || !chance(0.3)) continue;
    if (const Worker* other = place(session.fleet)) {
      --taken[session.worker_uid];
      ++taken[other->uid];
      session.worker_uid = other->uid;
      session.placed = world_.now;
    }
  }
  for (const auto& [name, count] : people_) {
    int have = sessions_of(name);
    for (std::size_t i = sessions_.size(); have > count && i-- > 0;) {
      if (sessions_[i].fleet != name) continue;
      sessions_.erase(sessions_.begin() + static_cast<std::ptrdiff_t>(i));
      --have;
    }
    for (; have < count; ++have) {
      const Worker* at = place(name);
      if (!at) break;
      ++taken[at->uid];
      sessions_.push_back({name, at->uid, world_.now});
    }
    if (count > 0) last_used_[name] = world_.now;
  }
}

void SimulatedCluster::push_telemetry() {
  if (silent_) return;
  if (world_.now - world_.listened_until > 1) world_.listening_since = world_.now;
  world_.listened_until = world_.now;
  std::erase_if(world_.telemetry, [&](const Telemetry& t) { return !worker_of(t.worker_uid); });
  for (const Worker& one : world_.workers) {
    const Pod* its = find_if(
        world_.pods, [&](const Pod& p) { return p.owner_uid == one.uid && p.name == one.name; });
    if (!its || !its->ready || its->phase != Phase::kRunning || !alive(its->node) ||
        hangs_[one.uid]) {
      continue;
    }
    const int sessions = sessions_on(one.uid);
    if (sessions > 0 || !idle_since_.contains(one.uid)) idle_since_[one.uid] = world_.now;
    Telemetry* sample =
        find_if(world_.telemetry, [&](const Telemetry& t) { return t.worker_uid == one.uid; });
    if (!sample) sample = &world_.telemetry.emplace_back();
    sample->worker_uid = one.uid;
    sample->epoch = its->epoch;
    sample->sampled = world_.now;
    sample->sessions = sessions;
    const Fleet* of = fleet(one.fleet, one.fleet_uid);
    sample->slots = of ? of->spec.sessions_per_worker : 1;
    sample->busy = std::min(1.0, 0.2 * sessions);
    sample->draining = drain_orders_.contains(one.uid);
    sample->idle_since = idle_since_[one.uid];
  }
  world_.demand.clear();
  for (const Fleet& of : world_.fleets) {
    world_.demand.push_back(
        {of.name, sessions_of(of.name), 0, waiting(of.name), last_used_[of.name], world_.now});
  }
}

void SimulatedCluster::step() {
  world_.now += 1;
  collect_garbage();
  schedule();
  run_kubelets();
  run_sessions();
  push_telemetry();
}

}  // namespace diaphane::fleet
