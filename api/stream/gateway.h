#pragma once

#include <prometheus/registry.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "api/service/placement.h"
#include "api/service/workers.h"
#include "common/result.h"
#include "common/wire/inner_tls.h"

namespace diaphane::api::stream {

struct GatewayLimits;

/// The WebSocket port: joins each viewer to the render worker of its session and passes messages on
/// unread (docs/contracts.md, "Stream"; docs/adr/0005). A few threads for all connections; each
/// connection has a strand, bounded queues both ways and time-outs for everything that it waits
/// for, so that nobody is slowed by another.
class Gateway {
 public:
  struct Options {
    std::string address = "127.0.0.1";  ///< the edge stands before it
    std::uint16_t port = 0;             ///< 0: any free one
    std::string public_url;             ///< pages of its origin may connect, no others
    unsigned threads = 2;
    wire::InnerTls tls{};  ///< to the workers
  };

  /// kInvalid: `public_url` is no http address. kUnavailable: the port cannot be opened. The
  /// interfaces and the registry must outlive it.
  static Result<std::unique_ptr<Gateway>> start(Options options, Placement& placement,
                                                Tickets& tickets, Workers& workers,
                                                prometheus::Registry& registry);
  /// The same with other limits, for tests.
  static Result<std::unique_ptr<Gateway>> start(Options options, const GatewayLimits& limits,
                                                Placement& placement, Tickets& tickets,
                                                Workers& workers, prometheus::Registry& registry);
  /// As stop() with no grace.
  ~Gateway();

  std::uint16_t port() const;
  /// Accepts nobody more, tells each viewer to come back (1001), and after `grace` closes what is
  /// left. Idempotent.
  void stop(std::chrono::milliseconds grace);

 private:
  struct Impl;
  explicit Gateway(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::api::stream
