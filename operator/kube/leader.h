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

/// Acquires and renews a Lease in its own thread.
class Leader {
 public:
  struct Options {
    std::string path;  ///< path of the leases of a namespace
    std::string name;
    LeaseDecision::Options lease;
    std::function<void()> won;
    std::function<void()> lost;  ///< called when the lease is lost; the program must exit at once
  };
  Leader(Options options, Api& api);
  /// Releases the lease, so that the next leader need not wait for it to expire.
  ~Leader();
  Leader(const Leader&) = delete;
  Leader& operator=(const Leader&) = delete;

  /// Returns whether this process leads. Check it before each write, because a process that was
  /// suspended may have lost the lease before its thread notices.
  bool leads() const;

 private:
  void run(const std::stop_token& stop);
  void poll();
  void write(bool held);
  void give_back();

  const Options options_;
  Api& api_;
  mutable std::mutex mutex_;
  LeaseDecision decision_;
  std::condition_variable_any wake_;
  std::mt19937_64 random_{std::random_device{}()};
  std::jthread thread_;  // last member, because it uses the others
};

/// Converts between a record and the Lease resource.
nlohmann::json lease_object(const std::string& name, const LeaseRecord& record);
LeaseRecord lease_record(const nlohmann::json& object);

}  // namespace diaphane::kube
