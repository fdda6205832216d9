#pragma once

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "common/wire/inner_tls.h"

namespace diaphane::api::stream {

/// One gRPC channel for each worker that is in use. Keyed by incarnation too: a worker that was
/// started again is tried at once, without the back-off of the one before. Thread-safe.
///
/// It holds them all until drop_unused(), because the last channel's end joins gRPC's callback
/// threads, and so must never come about on one of these (grpc 1.51, CallbackAlternativeCQ).
class WorkerChannels {
 public:
  explicit WorkerChannels(wire::InnerTls tls = {});
  /// Waits up to 2 s for the calls that still use a channel.
  ~WorkerChannels();
  WorkerChannels(const WorkerChannels&) = delete;
  WorkerChannels& operator=(const WorkerChannels&) = delete;

  std::shared_ptr<grpc::Channel> to(const std::string& address, const std::string& incarnation);
  /// Forgets those that nobody uses. May block a little: not for the threads of connections.
  void drop_unused();

 private:
  const wire::InnerTls tls_;
  const std::shared_ptr<grpc::ChannelCredentials> credentials_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<grpc::Channel>> channels_;
};

/// Whether anybody listens at "host:port". Blocks for at most `timeout` (and a name's look-up).
bool accepts_connections(const std::string& address, std::chrono::milliseconds timeout);

}  // namespace diaphane::api::stream
