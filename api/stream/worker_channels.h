#pragma once

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace diaphane::api::stream {

/// One gRPC channel for each worker that is in use, dropped with its last user. Keyed by
/// incarnation too: a worker that was started again is tried at once, without the back-off of the
/// one before. Thread-safe.
class WorkerChannels {
 public:
  std::shared_ptr<grpc::Channel> to(const std::string& address, const std::string& incarnation);

 private:
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<grpc::Channel>> channels_;
};

/// Whether anybody listens at "host:port". Blocks for at most `timeout` (and a name's look-up).
bool accepts_connections(const std::string& address, std::chrono::milliseconds timeout);

}  // namespace diaphane::api::stream
