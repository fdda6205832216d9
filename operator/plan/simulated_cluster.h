#pragma once

#include <map>
#include <random>
#include <string>
#include <vector>

#include "operator/plan/plan.h"
#include "operator/plan/world.h"

// For tests: an API server with its preconditions, garbage collectors, scheduler, kubelets, renderd
// and the placing of sessions, in steps of a second.

namespace diaphane::fleet {

class SimulatedCluster {
 public:
  explicit SimulatedCluster(std::uint64_t seed) : random_(seed) { world_.now = 1'000'000; }

  // What it holds now. Tests change it at will.
  World& world() { return world_; }
  /// As somebody sees it whose caches are whole and new.
  World observed() const;

  /// False: refused, as the API server would (exists, gone, another uid or version).
  bool apply(const Action& action);
  /// A second passes.
  void step();

  Fleet& add_fleet(const std::string& name);
  Node& add_node(const std::string& name, int gpus);
  /// So many people want a session of the fleet; who has none asks each second.
  void want_sessions(const std::string& fleet, int count) { people_[fleet] = count; }

  // Faults.
  void crash_pod(const std::string& name);  ///< its containers end, and it with them
  void lose_node(const std::string& name);  ///< neither heard of nor running anything
  void return_node(const std::string& name);
  void delete_node(const std::string& name);
  void hang(const std::string& worker, bool hangs);    ///< no heartbeat, pod goes on
  void silence(bool silent) { silent_ = silent; }      ///< no telemetry from anybody (Redis down)
  void refuse(const std::string& node, bool refuses);  ///< the scheduler finds no GPU there

  int sessions_on(const std::string& worker_uid) const;
  int sessions_of(const std::string& fleet) const;
  int waiting(const std::string& fleet) const;  ///< want one and have none
  int pods_on(const std::string& node) const;   ///< bound
  /// What must never happen, in words.
  const std::vector<std::string>& violations() const { return violations_; }

  bool chance(double p) { return std::uniform_real_distribution<>(0, 1)(random_) < p; }
  int up_to(int most) { return std::uniform_int_distribution<>(0, most)(random_); }

 private:
  struct Session {
    std::string fleet, worker_uid;
    Seconds placed = 0;
  };
  Worker* worker(const std::string& name, const std::string& uid);
  Worker* worker_of(const std::string& uid);
  Pod* pod(const std::string& name, const std::string& uid);
  Fleet* fleet(const std::string& name, const std::string& uid);
  Node* node(const std::string& name);
  std::string fresh(const char* kind) { return kind + std::to_string(++counter_); }
  bool alive(const std::string& node_name);
  bool takes_sessions(const Worker& worker);
  void end_sessions(const std::string& worker_uid);
  void collect_garbage();
  void schedule();
  void run_kubelets();
  void run_sessions();
  void push_telemetry();
  void drop_pod(const std::string& uid);

  bool carry_out(const CreateWorker& action);
  bool carry_out(const CreatePod& action);
  bool carry_out(const SetDrain& action);
  bool carry_out(const DeletePod& action);
  bool carry_out(const DeleteWorker& action);
  bool carry_out(const RemoveFinalizer& action);
  bool carry_out(const Restore& action);
  bool carry_out(const SetWorkerStatus& action);
  bool carry_out(const SetFleetStatus& action);

  World world_;
  std::mt19937_64 random_;
  std::uint64_t counter_ = 0;
  std::vector<Session> sessions_;
  std::map<std::string, int> people_;
  std::map<std::string, bool> lost_, hangs_, refuses_;
  std::map<std::string, Seconds> idle_since_;  // by worker uid
  std::map<std::string, Seconds> told_;        // to drain, by worker uid
  std::map<std::string, Seconds> last_used_;   // by fleet
  bool silent_ = false;
  std::vector<std::string> violations_;
};

}  // namespace diaphane::fleet
