#pragma once

#include <prometheus/registry.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/result.h"

namespace diaphane::service {

/// One thing a program needs in order to serve, checked when /readyz is asked (must answer within
/// 100 ms).
struct ReadyCheck {
  std::string name;  ///< "postgres", "redis", "volume store"
  std::function<bool()> ok;
};

/// The operations port, 127.0.0.1 (or `address`) only, never behind the edge:
///   /metrics  Prometheus text format
///   /healthz  200 while the process lives and its main loop runs; says nothing of what it depends
///   on /readyz   200 or 503, JSON {"ready": bool, "checks": {...}, plus `details`}
class AdminServer {
 public:
  struct Options {
    std::string address = "127.0.0.1";
    std::uint16_t port = 0;
    std::string program;  ///< "api", "ingestd", "renderd"
    std::vector<ReadyCheck> checks;
    std::function<std::string()> details;  ///< a JSON object merged into /readyz, or empty
  };

  /// kUnavailable when the port is taken.
  static Result<std::unique_ptr<AdminServer>> start(Options options);
  ~AdminServer();

  prometheus::Registry& registry() { return *registry_; }
  /// From now on /readyz answers 503: first step of a drain.
  void set_draining();

 private:
  struct Impl;
  explicit AdminServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
  std::shared_ptr<prometheus::Registry> registry_;
};

}  // namespace diaphane::service
