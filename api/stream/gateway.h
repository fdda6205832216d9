#pragma once

#include <prometheus/registry.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "api/shared/placement.h"
#include "api/shared/workers.h"
#include "common/result.h"
#include "common/wire/inner_tls.h"

namespace diaphane::api::stream {

struct GatewayLimits;

/// The WebSocket server. Connects each viewer to the render worker of its session and forwards
/// messages without parsing them (docs/contracts.md, "Stream"; docs/adr/0005). A few threads serve
/// all connections. Each connection has a strand, bounded queues in both directions and a timeout
/// for every wait, so that no viewer slows down another.
class Gateway {
 public:
  struct Options {
    std::string address = "127.0.0.1";  ///< only the edge connects to it
    std::uint16_t port = 0;             ///< 0 picks a free port
    std::string public_url;             ///< only pages of this origin may connect
    unsigned threads = 2;
    wire::InnerTls tls{};  ///< for connections to the workers
  };

  /// Returns kInvalid if `public_url` is not an http URL, or kUnavailable if the port cannot be
  /// opened. The interfaces and the registry must outlive the gateway.
  static Result<std::unique_ptr<Gateway>> start(Options options, Placement& placement,
                                                Tickets& tickets, Workers& workers,
                                                prometheus::Registry& registry);
  /// Starts a gateway with custom limits, for tests.
  static Result<std::unique_ptr<Gateway>> start(Options options, const GatewayLimits& limits,
                                                Placement& placement, Tickets& tickets,
                                                Workers& workers, prometheus::Registry& registry);
  /// Stops without a grace period.
  ~Gateway();

  std::uint16_t port() const;
  /// Stops accepting connections, asks each viewer to reconnect (1001) and closes the remaining
  /// ones after `grace`. Idempotent.
  void stop(std::chrono::milliseconds grace);

 private:
  struct Impl;
  explicit Gateway(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::api::stream
