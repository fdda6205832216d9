#pragma once

#include <atomic>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "directory/client.h"
#include "operator/act/carry_out.h"
#include "operator/kube/informer.h"
#include "operator/kube/leader.h"
#include "operator/kube/work_queue.h"
#include "operator/metrics.h"
#include "operator/observe/snapshot.h"
#include "operator/observe/telemetry.h"

namespace diaphane::fleet {

/// Observes the cluster, plans, and executes the plan (docs/adr/0024). All decisions are made in
/// operator/plan. This class owns the threads, the clock and the connections.
class Controller {
 public:
  struct Options {
    std::string name_space;
    bool all_pods = false;  ///< also watch other namespaces, whose pods use GPUs too
    kube::Leader::Options leader;
  };
  Controller(Options options, kube::Transport& transport, directory::Client& redis,
             Metrics& metrics);
  /// Releases the lease.
  ~Controller();
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  bool listed() const;     ///< whether every kind has been listed
  bool connected() const;  ///< whether the API server answers
  bool redis_answers() const { return redis_answers_; }
  bool leads() const { return leader_->leads(); }

 private:
  void changed();
  void run_plans(const std::stop_token& stop);
  void carry_out_all(const Plan& plan, const Snapshot& snapshot);
  void work(const Snapshot& snapshot, std::chrono::steady_clock::time_point until);
  void run_telemetry(const std::stop_token& stop);
  std::vector<std::string> fleet_names() const;
  std::vector<directory::DrainRequest> draining() const;
  bool wait_for_change(const std::stop_token& stop, std::chrono::nanoseconds least,
                       std::chrono::nanoseconds most);
  kube::Reflector::Options watched(const std::string& path, const char* kind) const;
  void report();

  const Options options_;
  kube::Transport& transport_;
  kube::Api api_;
  directory::Client& redis_;
  Metrics& metrics_;
  Templates templates_;
  TelemetryCache telemetry_cache_;
  std::atomic<bool> redis_answers_{false};

  std::mutex mutex_;
  std::condition_variable_any wake_;
  bool changed_ = true;

  // Actions of the plan in progress, by object.
  std::mutex work_mutex_;
  kube::WorkQueue queue_;
  std::map<std::string, std::vector<const Action*>> todo_;

  Events events_;
  ActionExecutor executor_;
  std::unique_ptr<kube::Informer<FleetObject>> fleets_;
  std::unique_ptr<kube::Informer<WorkerObject>> workers_;
  std::unique_ptr<kube::Informer<PodObject>> pods_;
  std::unique_ptr<kube::Informer<NodeObject>> nodes_;
  std::unique_ptr<kube::Leader> leader_;
  std::jthread planner_, telemetry_;
};

}  // namespace diaphane::fleet
