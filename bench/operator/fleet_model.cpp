#include "bench/operator/fleet_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "directory/constants.h"

namespace diaphane::fleet::bench {
namespace {

constexpr const char* kFleet = "render";
constexpr int kGpusANode = 8;

struct Spread {
  double count = 0, sum = 0, squares = 0;

  void add(double value) {
    ++count;
    sum += value;
    squares += value * value;
  }
  double mean() const { return sum / count; }
  /// Returns the standard deviation divided by the mean.
  double deviation() const {
    return std::sqrt(std::max(0.0, squares / count - mean() * mean())) / mean();
  }
};

}  // namespace

const char* name_of(Way way) {
  switch (way) {
    case Way::kLoad:
      return "load";
    case Way::kLoadAndLending:
      return "load-and-lending";
    case Way::kRoundRobin:
      return "round-robin";
    case Way::kLeastCount:
      return "least-count";
  }
  return "";
}

FleetModel::FleetModel(const Setting& setting, Way way)
    : setting_(setting),
      way_(way),
      random_(setting.seed),
      faults_(setting.seed + 1),
      normal_(setting.seed),
      lending_(setting.lending, setting.lending_costs, setting.seed + 2) {
  world_.now = 1'000'000;
  world_.complete = true;
  for (int i = 0; i < (setting.devices + kGpusANode - 1) / kGpusANode; ++i) {
    Node node;
    node.name = "node-" + std::to_string(10'000 + i);
    node.gpus = kGpusANode;
    world_.nodes.push_back(node);
  }
  Fleet fleet;
  fleet.name = fleet.uid = kFleet;
  fleet.finalizer = true;
  fleet.spec.sessions_per_worker = setting.slots;
  fleet.spec.template_hash = "one";
  fleet.spec.replicas = setting.devices;
  fleet.spec.drain_timeout = 60;
  world_.fleets.push_back(fleet);
  world_.demand.push_back({kFleet, 0, 0, 0, world_.now, world_.now});
}

double FleetModel::exponential(double mean) { return -mean * std::log1p(-unit()); }

Worker* FleetModel::worker(const std::string& name) {
  const auto found = workers_.find(name);
  return found == workers_.end() ? nullptr : &world_.workers[found->second];
}

Pod* FleetModel::pod(const std::string& name) {
  const auto found = pods_.find(name);
  return found == pods_.end() ? nullptr : &world_.pods[found->second];
}

int FleetModel::device_of(const std::string& name) {
  const auto [found, made] = numbers_.emplace(name, static_cast<int>(devices_.size()));
  if (made) {
    devices_.emplace_back();
    devices_.back().name = name;
  }
  return found->second;
}

bool FleetModel::open(int device) const {
  const Device& one = devices_[static_cast<std::size_t>(device)];
  return one.ready && !one.draining && one.sessions < setting_.slots;
}

void FleetModel::put(Session& session, int device) {
  session.device = device;
  Device& on = devices_[static_cast<std::size_t>(device)];
  ++on.sessions;
  ++on.given;
  on.shares += session.share;
  session.expected = {};  // a worker does not learn what another one measured
  if (session.looks) on.wants += session.share;
}

void FleetModel::take_out(Session& session) {
  if (session.device < 0) return;
  Device& on = devices_[static_cast<std::size_t>(session.device)];
  if (--on.sessions == 0) on.idle_since = world_.now;
  on.shares = std::max(0.0, on.shares - session.share);
  if (session.looks) on.wants = std::max(0.0, on.wants - session.share);
  session.device = -1;
}

int FleetModel::place(int but) {
  if (way_ == Way::kRoundRobin) {
    for (std::size_t tried = 0; tried < devices_.size(); ++tried) {
      const int device = static_cast<int>(turn_++ % devices_.size());
      if (device != but && open(device)) return device;
    }
    return -1;
  }
  int best = -1;
  const auto take_better = [&](int device, auto&& score) {
    if (device == but || !open(device)) return;
    if (best < 0 || score(device) < score(best)) best = device;
  };
  if (way_ == Way::kLeastCount) {
    for (std::size_t i = 0; i < devices_.size(); ++i) {
      take_better(static_cast<int>(i),
                  [&](int d) { return devices_[static_cast<std::size_t>(d)].sessions; });
    }
    return best;
  }
  // Samples again in case most devices are full.
  for (int tried = 0; best < 0 && tried < 8; ++tried) {
    for (int i = 0; i < directory::kSampledWorkers; ++i) {
      take_better(static_cast<int>(random_.below(devices_.size())),
                  [&](int d) { return score(d); });
    }
  }
  return best;
}

double FleetModel::score(int device) const {
  const Device& one = devices_[static_cast<std::size_t>(device)];
  // Sessions placed since the last heartbeat are not included in the expectation.
  return one.expected + double(one.given) / setting_.slots;
}

void FleetModel::strand(int device) {
  if (devices_[static_cast<std::size_t>(device)].sessions == 0) return;
  for (std::size_t i = 0; i < sessions_.size(); ++i) {
    if (sessions_[i].device != device) continue;
    take_out(sessions_[i]);
    waiting_.push_back(i);
  }
}

void FleetModel::remove_worker(const std::string& uid) {
  for (std::size_t i = 0; i < world_.workers.size(); ++i) {
    if (world_.workers[i].uid != uid) continue;
    workers_.erase(world_.workers[i].name);
    if (i + 1 < world_.workers.size()) {
      world_.workers[i] = std::move(world_.workers.back());
      workers_[world_.workers[i].name] = i;
    }
    world_.workers.pop_back();
    return;
  }
}

void FleetModel::remove_pod(const std::string& uid) {
  for (std::size_t i = 0; i < world_.pods.size(); ++i) {
    if (world_.pods[i].uid != uid) continue;
    const int device = device_of(world_.pods[i].name);
    strand(device);
    devices_[static_cast<std::size_t>(device)].ready = false;
    pods_.erase(world_.pods[i].name);
    if (i + 1 < world_.pods.size()) {
      world_.pods[i] = std::move(world_.pods.back());
      pods_[world_.pods[i].name] = i;
    }
    world_.pods.pop_back();
    return;
  }
}

void FleetModel::apply(const Action& action) {
  if (const auto* made = std::get_if<CreateWorker>(&action)) {
    if (worker(made->name)) return;
    Worker one;
    one.name = made->name;
    one.uid = made->name + "." + std::to_string(++counter_);
    one.fleet = one.fleet_uid = kFleet;
    one.node = made->node;
    one.template_hash = made->template_hash;
    one.created = world_.now;
    workers_[one.name] = world_.workers.size();
    world_.workers.push_back(one);
  } else if (const auto* pod_made = std::get_if<CreatePod>(&action)) {
    if (pod(pod_made->worker)) return;
    Pod one;
    one.name = pod_made->worker;
    one.uid = one.name + "." + std::to_string(++counter_);
    one.owned = true;
    one.owner_uid = pod_made->worker_uid;
    one.epoch = pod_made->epoch;
    one.node = pod_made->node;
    one.created = world_.now;
    pods_[one.name] = world_.pods.size();
    world_.pods.push_back(one);
    Device& device = devices_[static_cast<std::size_t>(device_of(one.name))];
    device.draining = false;
    device.ready_at = world_.now + 3 + exponential(5);
    device.idle_since = world_.now;
  } else if (const auto* drain = std::get_if<SetDrain>(&action)) {
    if (Worker* one = worker(drain->worker)) {
      one->drain = drain->drain;
      devices_[static_cast<std::size_t>(device_of(one->name))].draining = true;
    }
  } else if (const auto* gone = std::get_if<DeleteWorker>(&action)) {
    if (Worker* one = worker(gone->name)) one->deleted = world_.now;
  } else if (const auto* ended = std::get_if<DeletePod>(&action)) {
    if (Pod* one = pod(ended->name)) one->terminating = world_.now;
  } else if (const auto* freed = std::get_if<RemoveFinalizer>(&action)) {
    remove_worker(freed->uid);
  } else if (const auto* status = std::get_if<SetWorkerStatus>(&action)) {
    if (Worker* one = worker(status->name)) one->status = status->status;
  } else if (const auto* all = std::get_if<SetFleetStatus>(&action)) {
    world_.fleets[0].status = all->status;
  }
}

void FleetModel::reconcile(Figures& figures, bool measured) {
  const auto begin = std::chrono::steady_clock::now();
  const Plan made = plan(world_, random_.bits());
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  if (measured) figures.plan_seconds.push_back(took.count());
  for (const Action& action : made.actions) apply(action);
}

void FleetModel::trouble() {
  const auto some_node = [&]() -> Node& {
    return world_.nodes[faults_.below(world_.nodes.size())];
  };
  if (faults_.unit() < setting_.crashes_per_second && !world_.pods.empty()) {
    Pod& one = world_.pods[faults_.below(world_.pods.size())];
    const int device = device_of(one.name);
    if (devices_[static_cast<std::size_t>(device)].ready) {
      one.phase = Phase::kFailed;
      one.ready = devices_[static_cast<std::size_t>(device)].ready = false;
      strand(device);
    }
  }
  if (faults_.unit() < setting_.nodes_lost_per_second) {
    Node& node = some_node();
    node.ready = false;
    back_[node.name] = world_.now + 60;
  }
  if (faults_.unit() < setting_.cordons_per_second) {
    Node& node = some_node();
    node.cordoned = true;
    back_[node.name] = world_.now + 120;
  }
  for (Node& node : world_.nodes) {
    const auto due = back_.find(node.name);
    if (due == back_.end() || world_.now < due->second) continue;
    node.ready = true;
    node.cordoned = false;
    back_.erase(due);
  }
}

void FleetModel::run_pods() {
  std::unordered_map<std::string, bool> alive;
  for (const Node& node : world_.nodes) alive[node.name] = node.ready;
  std::vector<std::string> gone;
  for (Pod& one : world_.pods) {
    const int number = device_of(one.name);
    Device& device = devices_[static_cast<std::size_t>(number)];
    if (!alive[one.node]) {
      strand(number);
      device.ready = false;
      device.ready_at = world_.now + 1;
      continue;
    }
    if (one.phase == Phase::kFailed && !one.terminating) continue;
    if (one.terminating) {
      if (world_.now >= *one.terminating + 2) gone.push_back(one.uid);
    } else if (!device.ready && world_.now >= device.ready_at) {
      one.phase = Phase::kRunning;
      one.ready = device.ready = true;
    }
  }
  for (const std::string& uid : gone) remove_pod(uid);
}

void FleetModel::run_sessions(Figures& figures, bool measured, int target) {
  const double active =
      setting_.looking_seconds / (setting_.looking_seconds + setting_.resting_seconds);
  // The mean of a log-normal distribution is exp(mu + sigma^2 / 2).
  const double mean = setting_.wanted * setting_.devices / (setting_.sessions * active);
  const double mu = std::log(mean) - setting_.spread * setting_.spread / 2;
  std::normal_distribution<double> normal(mu, setting_.spread);
  for (Session& session : sessions_) {
    if (world_.now >= session.ends) {
      take_out(session);
      session.ends = 0;
    } else if (world_.now >= session.turns) {
      session.looks = !session.looks;
      if (session.device >= 0) {
        Device& on = devices_[static_cast<std::size_t>(session.device)];
        on.wants = std::max(0.0, on.wants + (session.looks ? session.share : -session.share));
      }
      session.turns = world_.now + exponential(session.looks ? setting_.looking_seconds
                                                             : setting_.resting_seconds);
    }
  }
  const auto count = [&](bool refused) {
    if (!measured) return;
    ++figures.placings;
    figures.refused += refused;
  };
  std::vector<std::size_t> again;
  for (const std::size_t i : waiting_) {
    if (sessions_[i].ends == 0) continue;
    const int device = place();
    count(device < 0);
    if (device < 0) {
      again.push_back(i);
      continue;
    }
    if (measured) ++figures.moves;
    put(sessions_[i], device);
  }
  waiting_ = again;
  for (Session& session : sessions_) {  // sessions of draining workers, within their grace period
    if (session.device < 0 || !devices_[static_cast<std::size_t>(session.device)].draining)
      continue;
    const int device = place(session.device);
    if (device < 0) continue;
    take_out(session);
    put(session, device);
    if (!measured) continue;
    ++figures.moves;
    ++figures.moved_alive;
  }
  std::size_t next = 0;
  for (int have = static_cast<int>(std::count_if(sessions_.begin(), sessions_.end(),
                                                 [](const Session& s) { return s.ends > 0; }));
       have < target; ++have) {
    const int device = place();
    count(device < 0);
    if (device < 0) continue;
    while (next < sessions_.size() && sessions_[next].ends > 0) ++next;
    if (next == sessions_.size()) sessions_.emplace_back();
    Session& session = sessions_[next];
    session = {};
    session.share = std::min(1.0, std::exp(normal(normal_)));
    session.ends = world_.now + exponential(setting_.stay_seconds);
    session.turns = world_.now + exponential(setting_.looking_seconds);
    put(session, device);
  }
}

void FleetModel::take_samples() {
  for (Device& device : devices_) device.expected = 0;
  for (Session& session : sessions_) {
    if (session.device < 0) continue;
    Device& device = devices_[static_cast<std::size_t>(session.device)];
    // An overloaded device gives each session a proportional part.
    session.expected.watch(1, session.looks ? session.share / std::max(1.0, device.wants) : 0);
    device.expected += session.expected.value(1.0 / setting_.slots);
  }
  world_.telemetry.clear();
  world_.listened_until = world_.now;
  int used = 0;
  for (const Worker& one : world_.workers) {
    Device& device = devices_[static_cast<std::size_t>(device_of(one.name))];
    used += device.sessions;
    device.node = node_numbers_.emplace(one.node, int(node_numbers_.size())).first->second;
    const Pod* its = pod(one.name);
    if (!its || !device.ready || its->owner_uid != one.uid) continue;
    Telemetry sample;
    sample.worker_uid = one.uid;
    sample.epoch = its->epoch;
    sample.sampled = world_.now;
    sample.busy = std::min(1.0, device.wants);
    sample.memory = 0.03 * device.sessions;
    sample.sessions = device.sessions;
    sample.slots = setting_.slots;
    // Waiting sessions have noisier images, so the sum of errors grows with demand.
    sample.error = device.wants;
    sample.draining = device.draining;
    sample.idle_since = device.idle_since;
    device.given = 0;
    world_.telemetry.push_back(sample);
  }
  world_.demand[0] = {kFleet, used, 0, static_cast<int>(waiting_.size()), world_.now, world_.now};
}

void FleetModel::lend_devices() {
  std::vector<LendingModel::Device> devices;
  devices.reserve(devices_.size());
  for (const Device& one : devices_) {
    devices.push_back({one.ready && !one.draining, one.draining, one.wants});
  }
  lending_.step(devices);
}

double FleetModel::load(std::size_t device) const {
  return way_ == Way::kLoadAndLending ? lending_.load(device) : devices_[device].wants;
}

void FleetModel::measure(Figures& figures) const {
  Spread loads, busy, stays, loads_by_node, stays_by_node;
  double late = 0, wants = 0;
  std::map<int, std::pair<Spread, Spread>> nodes;
  for (std::size_t i = 0; i < devices_.size(); ++i) {
    const Device& one = devices_[i];
    if (!one.ready || one.draining) continue;
    wants += one.wants;
    late += std::max(0.0, load(i) - 1);
    loads.add(load(i));
    busy.add(std::min(1.0, load(i)));
    stays.add(one.shares);
    nodes[one.node].first.add(load(i));
    nodes[one.node].second.add(one.shares);
  }
  if (wants == 0) return;
  late -= std::max(0.0, wants - loads.count);  // excludes what no placement could have avoided
  for (const auto& [node, its] : nodes) {
    loads_by_node.add(its.first.mean());
    stays_by_node.add(its.second.mean());
  }
  figures.lost += late / wants / setting_.seconds;
  figures.spread += loads.deviation() / setting_.seconds;
  figures.spread_of_busy += busy.deviation() / setting_.seconds;
  figures.spread_by_node += loads_by_node.deviation() / setting_.seconds;
  figures.spread_of_stays += stays.deviation() / setting_.seconds;
  figures.spread_of_stays_by_node += stays_by_node.deviation() / setting_.seconds;
  if (way_ == Way::kLoadAndLending) {
    figures.lent += lending_.lent() / loads.count / setting_.seconds;
    figures.helpers += double(lending_.helpers()) / loads.count / setting_.seconds;
    figures.begun += 60.0 * double(lending_.begun()) / loads.count / setting_.seconds;
  }
  std::unordered_map<std::string, int> on;
  for (const Worker& one : world_.workers) {
    if (++on[one.node] > kGpusANode) ++figures.over_committed;
  }
}

Figures FleetModel::run() {
  Figures figures;
  // The fleet is complete before the first users arrive.
  constexpr int kSetUp = 60;
  for (int second = -kSetUp; second < setting_.ramp_seconds + setting_.seconds; ++second) {
    world_.now += 1;
    const bool measured = second >= setting_.ramp_seconds;
    reconcile(figures, measured);
    if (measured) trouble();
    run_pods();
    const double share = std::min(1.0, double(second + 1) / setting_.ramp_seconds);
    if (second >= 0) {
      run_sessions(figures, measured, static_cast<int>(setting_.sessions * share));
    }
    take_samples();
    if (way_ == Way::kLoadAndLending) lend_devices();
    if (measured) measure(figures);
  }
  figures.refused /= std::max(1L, figures.placings);
  return figures;
}

}  // namespace diaphane::fleet::bench
