#include "api/stream/gateway.h"

#include <algorithm>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/strand.hpp>
#include <set>
#include <thread>
#include <vector>

#include "api/stream/connection.h"
#include "api/stream/handshake.h"
#include "common/log.h"

namespace diaphane::api::stream {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

struct Gateway::Impl {
  Impl(std::shared_ptr<Hub> shared, unsigned thread_count)
      : hub(std::move(shared)),
        io(static_cast<int>(thread_count)),
        work(io.get_executor()),
        acceptor(asio::make_strand(io)),
        pause(acceptor.get_executor()),
        watch(acceptor.get_executor()),
        links(acceptor.get_executor()) {}

  std::shared_ptr<Hub> hub;
  asio::io_context io;
  asio::executor_work_guard<asio::io_context::executor_type> work;
  tcp::acceptor acceptor;
  asio::steady_timer pause;
  asio::steady_timer watch;
  asio::steady_timer links;
  std::vector<std::thread> threads;
  std::uint16_t port = 0;
  bool stopped = false;

  void accept_next() {
    acceptor.async_accept(asio::make_strand(io), [this](error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted || !acceptor.is_open()) return;
      if (error) {
        // The process is probably out of file descriptors. Tries again, because connections close.
        pause.expires_after(std::chrono::milliseconds(100));
        pause.async_wait([this](error_code ended) {
          if (!ended) accept_next();
        });
        return;
      }
      const auto connection = std::make_shared<Connection>(hub, std::move(socket));
      if (hub->enter(connection)) {
        connection->start();
      } else {
        connection->refuse_busy();
      }
      accept_next();
    });
  }

  /// Checks the workers' heartbeats, because a hung or lost worker does not break its connections.
  void watch_workers() {
    watch.expires_after(hub->limits.watch);
    watch.async_wait([this](error_code ended) {
      if (ended) return;
      hub->run_blocking([shared = hub] {
        shared->channels.drop_unused();
        const auto alive = shared->workers.alive();
        if (!alive) return;  // Redis is unavailable, which says nothing about the workers
        std::set<std::string> keys;
        for (const WorkerInfo& one : *alive) keys.insert(one.id + "|" + one.incarnation);
        for (const auto& connection : shared->connections()) {
          const std::string key = connection->worker_key();
          if (!key.empty()) connection->on_worker_heartbeat(keys.contains(key));
        }
      });
      watch_workers();
    });
  }

  /// Disconnects guests whose link was disabled, which the REST API records only in Redis.
  void watch_links() {
    links.expires_after(hub->limits.links);
    links.async_wait([this](error_code ended) {
      if (ended) return;
      std::set<std::string> in_use;
      for (const auto& connection : hub->connections()) {
        if (std::string link = connection->link_hash(); !link.empty())
          in_use.insert(std::move(link));
      }
      if (!in_use.empty()) {
        hub->run_blocking(
            [shared = hub, asked = std::vector<std::string>(in_use.begin(), in_use.end())] {
              const auto over = shared->tickets.ended_links(asked);
              if (!over) return;  // Redis is unavailable, so guests stay until it answers again
              for (const auto& connection : shared->connections()) {
                const std::string link = connection->link_hash();
                if (link.empty() || std::find(over->begin(), over->end(), link) == over->end())
                  continue;
                connection->close(CloseCode::kLinkEnded, "This link has been disabled.");
              }
            });
      }
      watch_links();
    });
  }

  error_code listen(const std::string& address, std::uint16_t requested_port) {
    error_code error;
    const auto ip = asio::ip::make_address(address, error);
    if (error) return error;
    const tcp::endpoint endpoint(ip, requested_port);
    acceptor.open(endpoint.protocol(), error);
    if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (!error) port = acceptor.local_endpoint(error).port();
    return error;
  }

  void run(unsigned thread_count) {
    accept_next();
    watch_workers();
    watch_links();
    for (unsigned i = 0; i < thread_count; ++i) {
      threads.emplace_back([this] {
        for (;;) {
          try {
            io.run();
            return;
          } catch (const std::exception& failure) {
            // Only this connection fails, and the others continue.
            log::error("stream_handler_failed", {{"what", log::describe(failure)}});
          }
        }
      });
    }
  }

  void stop(std::chrono::milliseconds grace) {
    if (std::exchange(stopped, true)) return;
    asio::post(acceptor.get_executor(), [this] {
      error_code ignored;
      acceptor.close(ignored);
      pause.cancel();
      watch.cancel();
      links.cancel();
    });
    for (const auto& connection : hub->connections()) {
      connection->close(CloseCode::kGoingAway,
                        "The server is restarting. Please reconnect in a moment.");
    }
    if (!hub->wait_until_empty(grace)) {
      for (const auto& connection : hub->connections()) connection->abort();
      hub->wait_until_empty(std::chrono::seconds(3));
    }
    hub->join_blocking();
    work.reset();
    io.stop();
    for (std::thread& thread : threads) thread.join();
  }
};

Result<std::unique_ptr<Gateway>> Gateway::start(Options options, Placement& placement,
                                                Tickets& tickets, Workers& workers,
                                                prometheus::Registry& registry) {
  return start(std::move(options), GatewayLimits(), placement, tickets, workers, registry);
}

Result<std::unique_ptr<Gateway>> Gateway::start(Options options, const GatewayLimits& limits,
                                                Placement& placement, Tickets& tickets,
                                                Workers& workers, prometheus::Registry& registry) {
  std::string origin = origin_of(options.public_url);
  if (origin.empty())
    return fail(ErrorCode::kInvalid, "must be an http or https URL", "public-url");
  const unsigned threads = std::max(1u, options.threads);
  auto hub = std::make_shared<Hub>(limits, std::move(origin), placement, tickets, workers, registry,
                                   std::move(options.tls));
  auto impl = std::make_unique<Impl>(std::move(hub), threads);
  if (const error_code error = impl->listen(options.address, options.port)) {
    return fail(ErrorCode::kUnavailable, "the stream port " + std::to_string(options.port) +
                                             " cannot be opened: " + error.message());
  }
  impl->run(threads);
  return std::unique_ptr<Gateway>(new Gateway(std::move(impl)));
}

Gateway::Gateway(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Gateway::~Gateway() { stop(std::chrono::milliseconds(0)); }

std::uint16_t Gateway::port() const { return impl_->port; }
void Gateway::stop(std::chrono::milliseconds grace) { impl_->stop(grace); }

}  // namespace diaphane::api::stream
