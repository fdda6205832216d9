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

#include "api/service/placement.h"
#include "api/service/workers.h"
#include "api/stream/gateway_metrics.h"
#include "api/stream/worker_channels.h"

namespace diaphane::api::stream {

class Connection;

/// Bounds of one gateway; every one of them is a test.
struct GatewayLimits {
  std::size_t connections = 4096;  ///< at once, handshakes included
  std::size_t connections_per_user = 16;
  std::size_t guests_per_session = 60;  ///< who came by links
  std::size_t header_bytes = 8 * 1024;
  std::size_t message_bytes = 64 * 1024;  ///< of a viewer
  unsigned messages_per_second = 1000;    ///< of a viewer
  std::chrono::milliseconds handshake{10'000};
  std::chrono::milliseconds idle{40'000};    ///< a ping after half of it
  std::chrono::milliseconds write{10'000};   ///< for one message to a viewer
  std::chrono::milliseconds attach{3'000};   ///< for a worker to take the call
  std::chrono::milliseconds goodbye{2'000};  ///< for what a viewer sent last to reach its worker
  std::chrono::milliseconds probe{300};      ///< whether a worker that broke off can be reached
  std::chrono::milliseconds watch{2'000};    ///< between two looks at who is alive
  std::chrono::milliseconds links{500};      ///< between two looks at which links were ended
};

/// What all connections of one gateway share. Thread-safe.
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

  /// Runs what waits for Redis; false, and not run, when too much waits already.
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

  /// False when there are as many connections as there may be.
  bool enter(const std::shared_ptr<Connection>& connection);
  /// Last of all; the connection must not use the hub afterwards.
  void leave(Connection* connection);
  std::vector<std::shared_ptr<Connection>> connections() const;
  /// True once nobody is left.
  bool wait_until_empty(std::chrono::milliseconds timeout);

  /// One more connection of a person, or guest of a session; false when there are enough.
  bool enter_user(const Attachment& attachment);
  void leave_user(const Attachment& attachment);

  /// A worker broke off: can it be reached? If not, nobody is placed on it any more. Blocks (probe,
  /// Redis).
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
