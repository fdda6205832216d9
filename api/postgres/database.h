#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <pqxx/pqxx>
#include <string>
#include <type_traits>
#include <vector>

#include "api/service/account_store.h"
#include "common/result.h"

namespace diaphane::api {

/// Microseconds since 1970: how times travel to and from SQL (`to_timestamp($1::bigint / 1e6)`),
/// exact for timestamptz.
std::int64_t to_us(Time time);
Time from_us(std::int64_t us);

/// A bounded number of connections, opened when needed and opened anew after the server was away.
/// Thread-safe.
class Database {
 public:
  /// `url` is libpq's; at most `connections` at once. Connects to nothing yet.
  Database(std::string url, int connections);

  /// Runs `work(pqxx::work&) -> Result<T>` in a transaction: committed when it succeeds, else
  /// rolled back. It may run twice, when a connection turned out to be dead or two transactions
  /// were in each other's way, so it touches nothing but the transaction. kUnavailable: the server
  /// is away, or all connections are in use. Other SQL errors are defects and throw.
  template <typename Work>
  std::invoke_result_t<Work, pqxx::work&> transact(Work&& work);

  /// Within 100 ms when the server is on this machine.
  bool reachable();

 private:
  enum class Mishap { kAway, kInDoubt, kAgain, kDefect };
  class Lease {
   public:
    explicit Lease(Database& database);
    ~Lease();
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    bool granted() const { return granted_; }
    /// True when it has served before, so that it may have died unnoticed.
    bool reused() const { return reused_; }
    /// Throws pqxx::broken_connection when the server is away.
    pqxx::connection& connection();
    void discard() { connection_.reset(); }

   private:
    Database& database_;
    bool granted_ = false;
    bool reused_ = false;
    std::unique_ptr<pqxx::connection> connection_;
  };

  std::unique_ptr<pqxx::connection> connect() const;
  /// What the exception in flight means for `lease`.
  static Mishap judge(Lease& lease);
  static tl::unexpected<Error> away();
  static tl::unexpected<Error> all_in_use();

  const std::string url_;
  const std::size_t limit_;
  std::mutex mutex_;
  std::condition_variable freed_;
  std::size_t leased_ = 0;
  std::vector<std::unique_ptr<pqxx::connection>> idle_;
};

template <typename Work>
std::invoke_result_t<Work, pqxx::work&> Database::transact(Work&& work) {
  // Every idle connection is dead after the server was restarted; a fresh one is tried in the end.
  for (int attempt = 0;; ++attempt) {
    Lease lease(*this);
    if (!lease.granted()) return all_in_use();
    try {
      pqxx::work transaction(lease.connection());
      auto result = work(transaction);
      if (result) transaction.commit();
      return result;
    } catch (...) {
      const bool stale = lease.reused();
      switch (judge(lease)) {
        case Mishap::kDefect:
          throw;
        case Mishap::kAway:
          if (!stale || attempt > static_cast<int>(limit_)) return away();
          break;
        case Mishap::kInDoubt:
          return away();
        case Mishap::kAgain:
          if (attempt >= 3) return away();
          break;
      }
    }
  }
}

}  // namespace diaphane::api
