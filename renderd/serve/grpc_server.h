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

/// api/proto/worker.proto over gRPC, with gRPC's own health service. Only this, assist_reactor.h
/// and grpc_assistants.cpp name gRPC.
class GrpcServer {
 public:
  struct Options {
    std::string address = "127.0.0.1";  ///< or unix:/path, which has no port
    std::uint16_t port = 0;             ///< 0: a free one
    int most_streams = 256;             ///< concurrent calls on one connection
    int most_message_bytes = 1 << 20;
    wire::InnerTls tls{};  ///< on: who has no certificate of the CA is refused
  };

  /// kUnavailable when the port, or the socket, is taken. Without `assists` nobody is assisted.
  static Result<std::unique_ptr<GrpcServer>> start(Options options, SessionHost& host,
                                                   StillService& stills, Metrics& metrics,
                                                   AssistHost* assists = nullptr);
  ~GrpcServer();

  std::uint16_t port() const;
  /// The health service answers NOT_SERVING from now on.
  void set_not_serving();
  /// Cancels connections that were told to end and do not read; once a second.
  void sweep();
  /// Waits up to `grace` for calls to end, then cancels them. All of them must have been ended or
  /// be ended meanwhile (SessionHost::end_all, Runner::stop).
  void stop(std::chrono::milliseconds grace);

 private:
  struct Impl;
  explicit GrpcServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::render
