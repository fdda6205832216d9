#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/result.h"
#include "common/wire/inner_tls.h"
#include "renderd/serve/assist_session.h"
#include "renderd/serve/metrics.h"
#include "renderd/serve/session_host.h"
#include "renderd/serve/still_service.h"

namespace diaphane::render {

/// Serves api/proto/worker.proto over gRPC, with gRPC's own health service. Only this class,
/// assist_reactor.h and grpc_assistants.cpp depend on gRPC.
class GrpcServer {
 public:
  struct Options {
    std::string address = "127.0.0.1";  ///< or unix:/path, without a port
    std::uint16_t port = 0;             ///< 0: any free port
    int most_streams = 256;             ///< concurrent calls on one connection
    int most_message_bytes = 1 << 20;
    wire::InnerTls tls{};  ///< if on, clients without a certificate of the CA are refused
  };

  /// Starts to serve. Fails with kUnavailable if the port or socket is in use. Without `assists`,
  /// the worker assists no other.
  static Result<std::unique_ptr<GrpcServer>> start(Options options, SessionHost& host,
                                                   StillService& stills, Metrics& metrics,
                                                   AssistHost* assists = nullptr);
  ~GrpcServer();

  std::uint16_t port() const;
  /// Makes the health service answer NOT_SERVING.
  void set_not_serving();
  /// Cancels connections that should end but do not read. To be called once per second.
  void sweep();
  /// Waits up to `grace` for calls to end, then cancels them. All calls must have been ended, or be
  /// ended meanwhile (SessionHost::end_all, Runner::stop).
  void stop(std::chrono::milliseconds grace);

 private:
  struct Impl;
  explicit GrpcServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::render
