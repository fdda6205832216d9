#pragma once

#include <map>
#include <random>
#include <string>
#include <vector>

#include "operator/plan/cluster_state.h"
#include "operator/plan/plan.h"

// A simulation for tests of an API server with its preconditions, garbage collectors, scheduler,
// kubelets, renderd and the placement of sessions, in steps of one second.

namespace diaphane::fleet {

class SimulatedCluster {
 public:
  explicit SimulatedCluster(std::uint64_t seed) : random_(seed) { world_.now = 1'000'000; }

  // The actual state, which tests may change.
  ClusterState& world() { return world_; }
  /// The state as observed through complete and current caches.
  ClusterState observed() const;

  /// Returns false if the API server would reject the action (exists, not found, another uid or
  /// version).
  bool apply(const Action& action);
  /// Advances the time by one second.
  void step();

  Fleet& add_fleet(const std::string& name);
  Node& add_node(const std::string& name, int gpus);
  /// Sets how many users want a session of the fleet. Users without one ask every second.
  void want_sessions(const std::string& fleet, int count) { people_[fleet] = count; }

  // Faults.
  void crash_pod(const std::string& name);  ///< its containers terminate
  void lose_node(const std::string& name);  ///< the node is unreachable and runs nothing
  void return_node(const std::string& name);
  void delete_node(const std::string& name);
  void hang(const std::string& worker, bool hangs);  ///< no heartbeat, but the pod continues
  void silence(bool silent) { silent_ = silent; }    ///< no telemetry from any worker (Redis down)
  void refuse(const std::string& node, bool refuses);  ///< the scheduler finds no GPU on the node

  int sessions_on(const std::string& worker_uid) const;
  int sessions_of(const std::string& fleet) const;
  int waiting(const std::string& fleet) const;  ///< number of users without a session
  int gpus_on(const std::string& node) const;   ///< number of GPUs of bound pods
  /// Violated invariants, in words.
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

  ClusterState world_;
  std::mt19937_64 random_;
  std::uint64_t counter_ = 0;
  std::vector<Session> sessions_;
  std::map<std::string, int> people_;
  std::map<std::string, bool> lost_, hangs_, refuses_;
  std::map<std::string, Seconds> idle_since_;    // by worker uid
  std::map<std::string, Seconds> drain_orders_;  // workers to drain, by uid
  std::map<std::string, Seconds> last_used_;     // by fleet
  bool silent_ = false;
  std::vector<std::string> violations_;
};

}  // namespace diaphane::fleet
