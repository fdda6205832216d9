#pragma once

#include <prometheus/registry.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/config.h"
#include "common/result.h"

namespace diaphane::service {

/// A dependency of the program, checked for each /readyz request. The check must return within
/// 100 ms.
struct ReadyCheck {
  std::string name;  ///< "postgres", "redis", "volume store"
  std::function<bool()> ok;
};

/// The admin server. It listens on 127.0.0.1 (or `address`) and is never exposed by the edge proxy.
///  - /metrics: Prometheus text format.
///  - /healthz: 200 while the main loop of the process runs, whatever the state of its
///  dependencies.
///  - /readyz: 200 or 503, with the JSON {"ready": bool, "checks": {...}, plus `details`}.
class AdminServer {
 public:
  struct Options {
    std::string address = "127.0.0.1";
    std::uint16_t port = 0;
    std::string program;  ///< "api", "ingestd", "renderd"
    std::vector<ReadyCheck> checks;
    std::function<std::string()> details;  ///< JSON object to merge into /readyz, or empty
  };

  /// Starts the server. Returns kUnavailable if the port is in use.
  static Result<std::unique_ptr<AdminServer>> start(Options options);
  ~AdminServer();

  prometheus::Registry& registry() { return *registry_; }
  /// Makes /readyz return 503, the first step of draining.
  void set_draining();

 private:
  struct Impl;
  explicit AdminServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
  std::shared_ptr<prometheus::Registry> registry_;
};

/// Reads the settings admin-port and admin-address.
AdminServer::Options read_admin_options(ConfigReader& in, std::string program);

}  // namespace diaphane::service
