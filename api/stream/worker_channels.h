#pragma once

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "common/wire/inner_tls.h"

namespace diaphane::api::stream {

/// One gRPC channel per worker in use. Keys include the incarnation, so a restarted worker is tried
/// immediately without the back-off of its predecessor. Thread-safe.
///
/// Keeps all channels until drop_unused(). Destroying the last channel joins gRPC's callback
/// threads, so it must never happen on one of them (grpc 1.51, CallbackAlternativeCQ).
class WorkerChannels {
 public:
  explicit WorkerChannels(wire::InnerTls tls = {});
  /// Waits up to 2 s for calls that still use a channel.
  ~WorkerChannels();
  WorkerChannels(const WorkerChannels&) = delete;
  WorkerChannels& operator=(const WorkerChannels&) = delete;

  std::shared_ptr<grpc::Channel> to(const std::string& address, const std::string& incarnation);
  /// Drops unused channels. It may block briefly, so do not call it on a connection's thread.
  void drop_unused();

 private:
  const wire::InnerTls tls_;
  const std::shared_ptr<grpc::ChannelCredentials> credentials_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<grpc::Channel>> channels_;
};

/// Returns whether a server listens at the address. Blocks for at most `timeout` plus the lookup.
bool accepts_connections(const std::string& address, std::chrono::milliseconds timeout);

}  // namespace diaphane::api::stream
