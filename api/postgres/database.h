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

#include "api/service/account_store.h"
#include "common/postgres/connection.h"
#include "common/postgres/sql_fault.h"
#include "common/result.h"
#include "common/socket_deadlines.h"

namespace diaphane::api {

/// Microseconds since 1970: how times travel to and from SQL (`to_timestamp($1::bigint / 1e6)`),
/// exact for timestamptz.
std::int64_t to_us(Time time);
Time from_us(std::int64_t us);

/// A bounded number of connections, opened when needed and opened anew after the server was away.
/// Every call ends within a few seconds, also when the server is frozen: then its connection is
/// thrown away, and until the server answers again one call at a time tries it while all others are
/// refused at once. Thread-safe.
class Database {
 public:
  using CallSite = postgres::CallSite;

  /// `url` is libpq's; at most `connections` at once. Connects to nothing yet.
  Database(std::string url, int connections);

  /// Runs `work(pqxx::work&) -> Result<T>` in a transaction: committed when it succeeds, else
  /// rolled back. It may run several times, when a connection turned out to be dead or when other
  /// transactions were in its way, so it touches nothing but the transaction.
  ///
  /// kUnavailable: the server is away, or all connections are in use. kOutcomeUnknown: the server
  /// went away while it committed. kConflict: what the work refers to, or wants to make, was
  /// removed or made by others each time that it ran. Other SQL errors are defects and are thrown
  /// as postgres::SqlFault.
  template <typename Work>
  std::invoke_result_t<Work, pqxx::work&> transact(Work&& work,
                                                   CallSite where = CallSite::current()) {
    return run(work, true, kUsual, where);
  }

  /// The same for work that only reads. Nothing is committed, so the outcome is never unknown.
  template <typename Work>
  std::invoke_result_t<Work, pqxx::work&> read(Work&& work, CallSite where = CallSite::current()) {
    return run(work, false, kUsual, where);
  }

  /// Says within about two seconds whether the server answers.
  bool reachable();

 private:
  using SteadyTime = std::chrono::steady_clock::time_point;
  /// How long a call waits for a connection, and then for the server, all attempts together.
  struct Limits {
    std::chrono::milliseconds connection;
    std::chrono::milliseconds answer;
  };
  static constexpr postgres::Patience kPatience{};
  static constexpr Limits kUsual{std::chrono::seconds(2), kPatience.answer};
  static constexpr Limits kProbe{std::chrono::milliseconds(500), std::chrono::milliseconds(1500)};

  enum class Mishap { kAway, kInDoubt, kAgain, kConflict };

  class Lease {
   public:
    Lease(Database& database, std::chrono::milliseconds patience);
    ~Lease();
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    bool granted() const { return granted_; }
    /// True when it has served before, so that it may have died unnoticed.
    bool reused() const { return reused_; }
    /// Throws pqxx::broken_connection when the server is away.
    pqxx::connection& connection();
    void discard() { connection_.reset(); }
    /// The server answered, if only to refuse.
    void answered() { answered_ = true; }
    /// It did not answer in time.
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
  /// What the exception in flight means for `lease`. Throws SqlFault for a defect.
  static Mishap judge(Lease& lease, CallSite where);
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
  bool silent_ = false;   ///< the server did not answer in time, and has not answered since
  bool probing_ = false;  ///< a call tries whether it answers again
  std::vector<std::unique_ptr<pqxx::connection>> idle_;
};

template <typename Work>
std::invoke_result_t<Work, pqxx::work&> Database::run(Work& work, bool commit, const Limits& limits,
                                                      CallSite where) {
  constexpr int kConflicts = 3;
  std::optional<SteadyTime> deadline;  // from the first connection on
  int conflicts = 0;
  // Every idle connection is dead after the server was restarted; a fresh one is tried in the end.
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
        case Mishap::kAway:
          if (late || !stale || attempt > static_cast<int>(limit_)) return away();
          break;
        case Mishap::kInDoubt:
          return outcome_unknown();
        case Mishap::kAgain:
          if (++conflicts > kConflicts) return away();
          break;
        case Mishap::kConflict:
          if (++conflicts > kConflicts) return conflict(where);
          break;
      }
    }
  }
}

}  // namespace diaphane::api
