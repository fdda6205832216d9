#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <pqxx/pqxx>
#include <string>
#include <type_traits>
#include <vector>

#include "api/shared/time.h"
#include "common/postgres/connection.h"
#include "common/postgres/sql_fault.h"
#include "common/result.h"
#include "common/socket_deadlines.h"

namespace diaphane::api {

/// Converts to microseconds since 1970, the form of times in SQL parameters
/// (`to_timestamp($1::bigint / 1e6)`). Exact for timestamptz.
std::int64_t to_us(Time time);
Time from_us(std::int64_t us);

/// A bounded connection pool that opens connections on demand and reconnects after an outage. Every
/// call ends within a few seconds, even if the server is frozen. Then its connection is dropped,
/// and until the server responds again, one call at a time probes it while all others fail
/// immediately. Thread-safe.
class Database {
 public:
  using CallSite = postgres::CallSite;

  /// `url` is a libpq URI. Opens at most `connections`, on demand.
  Database(std::string url, int connections);

  /// Runs `work(pqxx::work&) -> Result<T>` in a transaction, which is committed if `work` succeeds
  /// and rolled back otherwise. `work` may run several times, because a connection was dead or
  /// because of a conflict with other transactions, so it must not change anything outside the
  /// transaction.
  ///
  /// Returns kUnavailable if the server is unavailable or all connections are in use,
  /// kOutcomeUnknown if the connection was lost during the commit, or kConflict if every run failed
  /// because other transactions removed or created the rows that `work` needs. Other SQL errors are
  /// bugs and are thrown as postgres::SqlFault.
  template <typename Work>
  std::invoke_result_t<Work, pqxx::work&> transact(Work&& work,
                                                   CallSite where = CallSite::current()) {
    return run(work, true, kUsual, where);
  }

  /// The same for read-only work. Nothing is committed, so the outcome is never unknown.
  template <typename Work>
  std::invoke_result_t<Work, pqxx::work&> read(Work&& work, CallSite where = CallSite::current()) {
    return run(work, false, kUsual, where);
  }

  /// Checks within about two seconds whether the server responds.
  bool reachable();

 private:
  using SteadyTime = std::chrono::steady_clock::time_point;
  /// Maximum wait for a connection, and then for the server, over all attempts.
  struct Limits {
    std::chrono::milliseconds connection;
    std::chrono::milliseconds answer;
  };
  static constexpr postgres::Patience kPatience{};
  static constexpr Limits kUsual{std::chrono::seconds(2), kPatience.answer};
  static constexpr Limits kProbe{std::chrono::milliseconds(500), std::chrono::milliseconds(1500)};

  enum class FailureKind { kUnavailable, kCommitUnknown, kRetry, kConflict };

  class Lease {
   public:
    Lease(Database& database, std::chrono::milliseconds patience);
    ~Lease();
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    bool granted() const { return granted_; }
    /// Returns whether the connection was used before, so that it may have died unnoticed.
    bool reused() const { return reused_; }
    /// Throws pqxx::broken_connection if the server is unavailable.
    pqxx::connection& connection();
    void discard() { connection_.reset(); }
    /// Records that the server responded, even with an error.
    void answered() { answered_ = true; }
    /// Records that the server did not respond in time.
    void silent();

   private:
    Database& database_;
    bool granted_ = false;
    bool reused_ = false;
    bool probe_ = false;
    bool answered_ = false;
    std::unique_ptr<pqxx::connection> connection_;
  };

  template <typename Work>
  std::invoke_result_t<Work, pqxx::work&> run(Work& work, bool commit, const Limits& limits,
                                              CallSite where);
  /// Classifies the current exception for `lease`. Throws SqlFault for a bug.
  static FailureKind judge(Lease& lease, CallSite where);
  tl::unexpected<Error> not_granted();
  static tl::unexpected<Error> away();
  static tl::unexpected<Error> outcome_unknown();
  static tl::unexpected<Error> conflict(CallSite where);

  const std::string url_;
  const std::size_t limit_;
  SocketDeadlines deadlines_;  // outlives the connections
  std::mutex mutex_;
  std::condition_variable freed_;
  std::size_t leased_ = 0;
  bool silent_ = false;   ///< the server timed out and has not responded since
  bool probing_ = false;  ///< a call is probing whether it responds again
  std::vector<std::unique_ptr<pqxx::connection>> idle_;
};

template <typename Work>
std::invoke_result_t<Work, pqxx::work&> Database::run(Work& work, bool commit, const Limits& limits,
                                                      CallSite where) {
  constexpr int kConflicts = 3;
  std::optional<SteadyTime> deadline;  // set with the first connection
  int conflicts = 0;
  // All idle connections are dead after a server restart, so the last attempt opens a new one.
  for (int attempt = 0;; ++attempt) {
    Lease lease(*this, limits.connection);
    if (!lease.granted()) return not_granted();
    if (!deadline) deadline = std::chrono::steady_clock::now() + limits.answer;
    std::optional<SocketDeadlines::Guard> guard;
    try {
      pqxx::connection& connection = lease.connection();
      guard.emplace(deadlines_, connection.sock(), *deadline);
      pqxx::work transaction(connection);
      auto result = work(transaction);
      if (result && commit) {
        transaction.commit();
      } else {
        transaction.abort();
      }
      lease.answered();
      return result;
    } catch (...) {
      const bool late = guard && guard->passed();
      const bool stale = lease.reused();
      if (late) lease.silent();
      switch (judge(lease, where)) {
        case FailureKind::kUnavailable:
          if (late || !stale || attempt > static_cast<int>(limit_)) return away();
          break;
        case FailureKind::kCommitUnknown:
          return outcome_unknown();
        case FailureKind::kRetry:
          if (++conflicts > kConflicts) return away();
          break;
        case FailureKind::kConflict:
          if (++conflicts > kConflicts) return conflict(where);
          break;
      }
    }
  }
}

}  // namespace diaphane::api
