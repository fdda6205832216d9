#include "operator/controller.h"

#include <algorithm>

#include "common/ids.h"
#include "common/log.h"
#include "operator/names.h"

namespace diaphane::fleet {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::steady_clock;

constexpr milliseconds kTelemetry{1000};
/// Changes within this time are planned together.
constexpr milliseconds kGather{10};
/// Planning takes at most 1 / kPlanningShare of the time.
constexpr int kPlanningShare = 5;
constexpr unsigned kWriters = 4;
/// A plan is executed for at most this long. What remains is planned again, so that thousands of
/// workers to create do not delay anything more urgent.
constexpr milliseconds kBatch{1000};

Seconds wall() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace

Controller::Controller(Options options, kube::Transport& transport, directory::Client& redis,
                       Metrics& metrics)
    : options_(std::move(options)),
      transport_(transport),
      api_(transport, kManager),
      redis_(redis),
      metrics_(metrics),
      events_(api_, options_.name_space),
      executor_({options_.name_space,
                 [this](Kind kind, const Json& object) {
                   if (kind == Kind::kFleet) fleets_->apply_own_write(object);
                   if (kind == Kind::kWorker) workers_->apply_own_write(object);
                   if (kind == Kind::kPod) pods_->apply_own_write(object);
                 }},
                api_, events_) {
  const std::string ours = "/apis/" + std::string(kVersion) + "/namespaces/" + options_.name_space;
  const auto notify = [this] { changed(); };
  fleets_ = std::make_unique<kube::Informer<FleetObject>>(
      watched(ours + "/renderfleets", "renderfleets"), transport, read_fleet, notify);
  workers_ = std::make_unique<kube::Informer<WorkerObject>>(
      watched(ours + "/renderworkers", "renderworkers"), transport,
      [this](const Json& object) { return read_worker(object, templates_); }, notify);
  pods_ = std::make_unique<kube::Informer<PodObject>>(
      watched(options_.all_pods ? "/api/v1/pods"
                                : "/api/v1/namespaces/" + options_.name_space + "/pods",
              "pods"),
      transport,
      [home = options_.name_space](const Json& object) { return read_pod(object, home); }, notify);
  nodes_ = std::make_unique<kube::Informer<NodeObject>>(watched("/api/v1/nodes", "nodes"),
                                                        transport, read_node, notify);
  kube::Leader::Options leader = options_.leader;
  leader.won = [this] { changed(); };
  leader_ = std::make_unique<kube::Leader>(std::move(leader), api_);
  telemetry_ = std::jthread([this](const std::stop_token& stop) { run_telemetry(stop); });
  planner_ = std::jthread([this](const std::stop_token& stop) { run_plans(stop); });
}

Controller::~Controller() {
  // Requests both threads to stop before joining either.
  planner_.request_stop();
  telemetry_.request_stop();
  planner_ = {};
  telemetry_ = {};
  leader_.reset();
  // The watches block on reads until the transport stops.
  transport_.stop();
}

kube::Reflector::Options Controller::watched(const std::string& path, const char* kind) const {
  kube::Reflector::Options options;
  options.path = path;
  options.kind = kind;
  options.home = options_.name_space;
  return options;
}

bool Controller::listed() const {
  return fleets_->store().listed() && workers_->store().listed() && pods_->store().listed() &&
         nodes_->store().listed();
}

bool Controller::connected() const {
  return fleets_->reflector().connected() && workers_->reflector().connected() &&
         pods_->reflector().connected() && nodes_->reflector().connected();
}

void Controller::changed() {
  {
    const std::lock_guard lock(mutex_);
    changed_ = true;
  }
  wake_.notify_all();
}

bool Controller::wait_for_change(const std::stop_token& stop, nanoseconds least, nanoseconds most) {
  std::unique_lock lock(mutex_);
  wake_.wait_for(lock, stop, least, [] { return false; });
  wake_.wait_for(lock, stop, std::max(nanoseconds(0), most - least), [this] { return changed_; });
  changed_ = false;
  return !stop.stop_requested();
}

void Controller::run_plans(const std::stop_token& stop) {
  Observer observer(fleets_->store(), workers_->store(), pods_->store(), nodes_->store());
  nanoseconds next = kTelemetry;
  nanoseconds least = kGather;
  while (wait_for_change(stop, least, next)) {
    report();
    next = kTelemetry;
    if (!listed() || !leader_->leads()) continue;
    const auto begun = steady_clock::now();
    Snapshot& snapshot = observer.snapshot(wall());
    snapshot.world.complete = true;
    telemetry_cache_.fill(snapshot.world);
    const Plan current_plan =
        plan(snapshot.world, static_cast<std::uint64_t>(begun.time_since_epoch().count()));
    const nanoseconds spent = steady_clock::now() - begun;
    metrics_.planned(std::chrono::duration<double>(spent).count());
    least = std::max<nanoseconds>(kGather, spent * (kPlanningShare - 1));
    carry_out_all(current_plan, snapshot);
    if (current_plan.requeue_after) {
      next = std::chrono::duration_cast<nanoseconds>(
          std::chrono::duration<double>(std::clamp(*current_plan.requeue_after, 0.001, 60.0)));
    }
    const std::lock_guard lock(work_mutex_);
    // Failed actions are retried with a new plan of the state at that time.
    if (const auto due = queue_.next()) {
      next = std::clamp<nanoseconds>(*due - steady_clock::now(), nanoseconds(1), next);
    }
  }
}

void Controller::carry_out_all(const Plan& current_plan, const Snapshot& snapshot) {
  {
    const std::lock_guard lock(work_mutex_);
    todo_.clear();
    auto due = steady_clock::now();
    for (const Action& action : current_plan.actions) {
      auto& actions = todo_[key_of(action)];
      if (actions.empty()) queue_.put(key_of(action), due);
      actions.push_back(&action);
      due += nanoseconds(1);  // keeps the plan's order
    }
  }
  const auto until = steady_clock::now() + kBatch;
  if (current_plan.actions.empty()) return work(snapshot, until);
  const auto count = std::min<std::size_t>(kWriters, current_plan.actions.size());
  std::vector<std::jthread> writers;
  for (std::size_t i = 1; i < count; ++i) writers.emplace_back([&] { work(snapshot, until); });
  work(snapshot, until);
}

void Controller::work(const Snapshot& snapshot, steady_clock::time_point until) {
  while (steady_clock::now() < until) {
    std::string key;
    std::vector<const Action*> actions;
    {
      const std::lock_guard lock(work_mutex_);
      const auto taken = queue_.take(steady_clock::now());
      if (!taken) return;
      key = *taken;
      const auto found = todo_.find(key);
      if (found == todo_.end()) {
        // The action failed earlier, and the plan no longer contains it.
        queue_.forget(key);
        queue_.done(key);
        continue;
      }
      actions = found->second;
    }
    Result<void> done =
        fail(ErrorCode::kUnavailable, "this operator is not the leader", "NotLeading");
    // A process that was suspended notices here that another process leads.
    if (leader_->leads()) done = executor_.carry_out(actions, snapshot);
    for (const Action* action : actions) metrics_.action(name_of(*action), done.has_value());
    const std::lock_guard lock(work_mutex_);
    if (done) {
      queue_.forget(key);
    } else {
      const bool expected = done.error().code == ErrorCode::kConflict;
      log::write(expected ? log::Level::kInfo : log::Level::kWarning, "action_failed",
                 {{"action", name_of(*actions.front())},
                  {"object", key},
                  {"reason", done.error().field},
                  {"message", done.error().message}});
      queue_.failed(key, steady_clock::now());
    }
    queue_.done(key);
  }
}

std::vector<std::string> Controller::fleet_names() const {
  std::vector<std::string> names;
  fleets_->store().visit([&](const auto& all) {
    for (const auto& [name, one] : all) names.push_back(name);
  });
  return names;
}

std::vector<directory::DrainRequest> Controller::draining() const {
  std::vector<directory::DrainRequest> requests;
  if (!leader_->leads()) return requests;
  std::vector<WorkerObject> leaving;
  workers_->store().visit([&](const auto& all) {
    for (const auto& [name, one] : all) {
      if (one.worker.drain || one.worker.deleted) leaving.push_back(one);
    }
  });
  for (const WorkerObject& one : leaving) {
    const auto pod = pods_->store().find(one.name);  // a pod has its worker's name
    if (!pod || !pod->pod.owned || pod->pod.owner_uid != one.uid) continue;
    requests.push_back({one.name, owner_text(one.worker.fleet, one.uid, pod->pod.epoch)});
  }
  return requests;
}

void Controller::run_telemetry(const std::stop_token& stop) {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, stop, kTelemetry, [] { return false; });
      if (stop.stop_requested()) return;
    }
    if (!listed()) {
      redis_answers_ = redis_.answers(milliseconds(500));
      continue;
    }
    auto answer = ask_fleets(redis_, fleet_names(), draining(), wall);
    if (redis_answers_ != answer.has_value()) {
      log::info(answer ? "redis_connected" : "redis_lost");
    }
    redis_answers_ = answer.has_value();
    if (!answer) {
      telemetry_cache_.missed();
      continue;
    }
    telemetry_cache_.note(*std::move(answer), wall());
    changed();
  }
}

void Controller::report() {
  metrics_.leads(leader_->leads());
  for (const kube::Reflector* one :
       {&fleets_->reflector(), &workers_->reflector(), &pods_->reflector(), &nodes_->reflector()}) {
    metrics_.watch(one->kind(), one->counts());
  }
}

}  // namespace diaphane::fleet
