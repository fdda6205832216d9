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

#include "api/redis/client.h"
#include "operator/act/carry_out.h"
#include "operator/kube/informer.h"
#include "operator/kube/leader.h"
#include "operator/kube/work_queue.h"
#include "operator/metrics.h"
#include "operator/observe/snapshot.h"
#include "operator/observe/telemetry.h"

namespace diaphane::fleet {

/// Observes, plans, carries out (docs/adr/0024). Everything that is decided is in operator/plan;
/// here are the threads, the clock and the wires.
class Controller {
 public:
  struct Options {
    std::string name_space;
    bool all_pods = false;  ///< those of other namespaces hold GPUs, too
    kube::Leader::Options leader;
  };
  Controller(Options options, kube::Transport& transport, api::redis::Client& redis,
             Metrics& metrics);
  /// Gives the lease back.
  ~Controller();
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  bool listed() const;     ///< every kind
  bool connected() const;  ///< to the API server
  bool redis_answers() const { return redis_answers_; }
  bool leads() const { return leader_->leads(); }

 private:
  void changed();
  void run_plans(const std::stop_token& stop);
  void carry_out_all(const Plan& plan, const Snapshot& seen);
  void work(const Snapshot& seen, std::chrono::steady_clock::time_point until);
  void run_telemetry(const std::stop_token& stop);
  std::vector<std::string> fleet_names() const;
  std::vector<Draining> draining() const;
  bool wait_for_change(const std::stop_token& stop, std::chrono::nanoseconds least,
                       std::chrono::nanoseconds most);
  kube::Reflector::Options watched(const std::string& path, const char* kind) const;
  void report();

  const Options options_;
  kube::Transport& transport_;
  kube::Api api_;
  api::redis::Client& redis_;
  Metrics& metrics_;
  Templates templates_;
  TelemetryBook book_;
  std::atomic<bool> redis_answers_{false};

  std::mutex mutex_;
  std::condition_variable_any wake_;
  bool changed_ = true;

  // Actions of the plan that is carried out, by object.
  std::mutex work_mutex_;
  kube::WorkQueue queue_;
  std::map<std::string, std::vector<const Action*>> todo_;

  Events events_;
  Carrier carrier_;
  std::unique_ptr<kube::Informer<FleetObject>> fleets_;
  std::unique_ptr<kube::Informer<WorkerObject>> workers_;
  std::unique_ptr<kube::Informer<PodObject>> pods_;
  std::unique_ptr<kube::Informer<NodeObject>> nodes_;
  std::unique_ptr<kube::Leader> leader_;
  std::jthread planner_, telemetry_;
};

}  // namespace diaphane::fleet
