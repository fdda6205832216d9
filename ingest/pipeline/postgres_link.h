#pragma once

#include <sys/socket.h>

#include <chrono>
#include <memory>
#include <pqxx/pqxx>
#include <string>
#include <thread>
#include <utility>

#include "common/log.h"
#include "common/postgres/connection.h"
#include "common/postgres/sql_fault.h"
#include "common/result.h"
#include "common/socket_deadlines.h"
#include "ingest/pipeline/lease.h"

namespace diaphane::ingest {

/// Returns a time as Postgres's make_interval expects it.
inline double seconds_of(std::chrono::milliseconds span) {
  return static_cast<double>(span.count()) / 1000;
}

/// One connection to Postgres, which is opened on demand and reopened after a loss. Listens to
/// `channel` unless it is empty. Not thread-safe.
class PostgresLink {
 public:
  explicit PostgresLink(std::string url, std::string channel = {})
      : url_(std::move(url)), channel_(std::move(channel)) {}
  ~PostgresLink() { disconnect(); }
  PostgresLink(const PostgresLink&) = delete;
  PostgresLink& operator=(const PostgresLink&) = delete;

  /// Runs `work` in its own transaction and commits it. Ends within seconds even if Postgres is
  /// frozen, with kUnavailable.
  template <typename Work>
  auto transact(Work work, postgres::CallSite where = postgres::CallSite::current())
      -> Result<decltype(work(std::declval<pqxx::work&>()))> {
    try {
      pqxx::connection& used = connected();
      const SocketDeadlines::Guard guard(deadlines_, used.sock(),
                                         std::chrono::steady_clock::now() + kPatience.answer);
      pqxx::work transaction(used);
      auto value = work(transaction);
      transaction.commit();
      return value;
    } catch (const pqxx::broken_connection&) {
    } catch (const pqxx::in_doubt_error&) {
      // The commit may or may not have succeeded. The caller retries, and every operation here is
      // idempotent.
    } catch (const pqxx::sql_error& error) {
      const std::string& state = error.sqlstate();
      const bool passing = state.starts_with("57") || state.starts_with("53") ||
                           state.starts_with("08") || state.starts_with("40") || state == "55P03";
      if (!passing && state != last_state_) {
        log::error("sql_error", {{"reason", postgres::SqlFault(error, where).what()}});
      }
      last_state_ = state;
    } catch (const pqxx::failure&) {
    }
    disconnect();
    return fail(ErrorCode::kUnavailable, "Postgres is unavailable");
  }

  /// Returns true once a transaction has notified the channel since the last call, or false after
  /// `longest`. Notifications are lost while there is no connection.
  bool wait_for_notification(std::chrono::milliseconds longest) {
    const auto end = std::chrono::steady_clock::now() + longest;
    try {
      if (receiver_ && !receiver_->notified) {
        const auto us = std::chrono::microseconds(longest).count();
        connection_->await_notification(static_cast<long>(us / 1'000'000),
                                        static_cast<long>(us % 1'000'000));
      }
    } catch (const pqxx::failure&) {
      disconnect();
    }
    if (receiver_ && std::exchange(receiver_->notified, false)) return true;
    std::this_thread::sleep_until(end);  // without a connection, or after another notification
    return false;
  }

 private:
  static constexpr postgres::Patience kPatience{};

  struct Receiver : pqxx::notification_receiver {
    using pqxx::notification_receiver::notification_receiver;
    void operator()(const std::string& /*payload*/, int /*sender*/) override { notified = true; }
    bool notified = false;
  };

  pqxx::connection& connected() {
    if (!connection_) {
      connection_ = postgres::connect(url_, "ingestd", kPatience, deadlines_);
      if (!channel_.empty()) {
        const SocketDeadlines::Guard guard(deadlines_, connection_->sock(),
                                           std::chrono::steady_clock::now() + kPatience.answer);
        receiver_ = std::make_unique<Receiver>(*connection_, channel_);
      }
    }
    return *connection_;
  }

  void disconnect() {
    // The receiver tells the server that it stops listening. A frozen server would not answer.
    if (receiver_) ::shutdown(connection_->sock(), SHUT_RDWR);
    receiver_.reset();
    connection_.reset();
  }

  std::string url_;
  std::string channel_;
  SocketDeadlines deadlines_{};  ///< outlives the connection
  std::unique_ptr<pqxx::connection> connection_{};
  std::unique_ptr<Receiver> receiver_{};
  std::string last_state_{};  ///< SQLSTATE of the last error, to log a repeated one only once
};

/// The connection of a queue whose jobs are claimed for a time.
struct LeasedLink : PostgresLink {
  explicit LeasedLink(LeaseOptions options, std::string channel = {})
      : PostgresLink(std::move(options.url), std::move(channel)),
        claimer(std::move(options.claimer)),
        lease_seconds(seconds_of(options.lease)) {}

  std::string claimer;
  double lease_seconds;
};

}  // namespace diaphane::ingest
