#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <random>
#include <stop_token>
#include <string>
#include <thread>

#include "operator/kube/api.h"
#include "operator/kube/lease.h"

namespace diaphane::kube {

/// Holds a Lease, or waits for it, in a thread of its own.
class Leader {
 public:
  struct Options {
    std::string path;  ///< of the leases of a namespace
    std::string name;
    LeaseDecision::Options lease;
    std::function<void()> won;
    std::function<void()> lost;  ///< the program is to end, now
  };
  Leader(Options options, Api& api);
  /// Gives the lease back, so that the next need not wait for its end.
  ~Leader();
  Leader(const Leader&) = delete;
  Leader& operator=(const Leader&) = delete;

  /// Asked before each write: a process that stood still finds out here, not by its thread.
  bool leads() const;

 private:
  void run(const std::stop_token& stop);
  void look();
  void write(bool held);
  void give_back();

  const Options options_;
  Api& api_;
  mutable std::mutex mutex_;
  LeaseDecision decision_;
  std::condition_variable_any wake_;
  std::mt19937_64 random_{std::random_device{}()};
  std::jthread thread_;  // last: it uses the rest
};

/// The Lease's resource of a record, and back.
nlohmann::json lease_object(const std::string& name, const LeaseRecord& record);
LeaseRecord lease_record(const nlohmann::json& object);

}  // namespace diaphane::kube
