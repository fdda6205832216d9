#pragma once

#include <atomic>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "api/shared/placement.h"
#include "api/shared/workers.h"
#include "api/stream/gateway_metrics.h"
#include "api/stream/worker_channels.h"

namespace diaphane::api::stream {

class Connection;

/// Limits of one gateway. Each has a test.
struct GatewayLimits {
  std::size_t connections = 4096;  ///< simultaneous connections, including handshakes
  std::size_t connections_per_user = 16;
  std::size_t guests_per_session = 60;  ///< guests who joined with links
  std::size_t header_bytes = 8 * 1024;
  std::size_t message_bytes = 64 * 1024;  ///< per viewer message
  unsigned messages_per_second = 1000;    ///< per viewer
  std::chrono::milliseconds handshake{10'000};
  std::chrono::milliseconds idle{40'000};   ///< idle timeout; a ping is sent after half of it
  std::chrono::milliseconds write{10'000};  ///< timeout for sending one message to a viewer
  std::chrono::milliseconds attach{3'000};  ///< timeout for a worker to accept the call
  /// Time for a viewer's last messages to reach the worker.
  std::chrono::milliseconds goodbye{2'000};
  std::chrono::milliseconds probe{300};    ///< timeout of the probe of a disconnected worker
  std::chrono::milliseconds watch{2'000};  ///< interval between checks for live workers
  std::chrono::milliseconds links{500};    ///< interval between checks for disabled links
};

/// State that all connections of one gateway share. Thread-safe.
class Hub {
 public:
  Hub(const GatewayLimits& bounds, std::string origin, Placement& places, Tickets& entries,
      Workers& renderers, prometheus::Registry& registry, wire::InnerTls tls)
      : limits(bounds),
        public_origin(std::move(origin)),
        placement(places),
        tickets(entries),
        workers(renderers),
        metrics(registry),
        channels(std::move(tls)) {}

  const GatewayLimits limits;
  const std::string public_origin;
  Placement& placement;
  Tickets& tickets;
  Workers& workers;
  GatewayMetrics metrics;
  WorkerChannels channels;

  /// Runs a task that waits for Redis. Returns false without running it if too many are waiting.
  template <typename Job>
  bool run_blocking(Job job) {
    if (waiting_jobs_.fetch_add(1) >= kMostWaitingJobs) {
      --waiting_jobs_;
      return false;
    }
    boost::asio::post(blocking_, [this, job = std::move(job)]() mutable {
      job();
      --waiting_jobs_;
    });
    return true;
  }
  void join_blocking() { blocking_.join(); }

  /// Adds a connection. Returns false if there are too many, so that the caller must refuse it.
  bool enter(const std::shared_ptr<Connection>& connection);
  /// Removes a connection, which must not use the hub afterwards.
  void leave(Connection* connection);
  std::vector<std::shared_ptr<Connection>> connections() const;
  /// Returns true once no connection is left, or false after `timeout`.
  bool wait_until_empty(std::chrono::milliseconds timeout);

  /// Counts another connection of a user, or of a session's guests. Returns false at the limit.
  bool enter_user(const Attachment& attachment);
  void leave_user(const Attachment& attachment);

  /// Probes a worker that broke off a stream. If it cannot be reached, marks it as lost in Redis,
  /// so that no more sessions are placed on it. Blocks.
  void worker_broke_off(const Attachment& attachment);

 private:
  static constexpr int kMostWaitingJobs = 512;

  std::atomic<int> waiting_jobs_ = 0;
  boost::asio::thread_pool blocking_{2};

  mutable std::mutex mutex_;
  std::condition_variable empty_;
  std::map<Connection*, std::weak_ptr<Connection>> connections_;
  std::map<std::string, std::size_t> users_;
};

}  // namespace diaphane::api::stream
