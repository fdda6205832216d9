#pragma once

#include <chrono>
#include <memory>
#include <pqxx/pqxx>
#include <string>
#include <utility>

#include "common/log.h"
#include "common/postgres/connection.h"
#include "common/postgres/sql_fault.h"
#include "common/result.h"
#include "common/socket_deadlines.h"

namespace diaphane::ingest {

/// One connection to Postgres, which is opened on demand and reopened after a loss. Not
/// thread-safe.
class PostgresLink {
 public:
  explicit PostgresLink(std::string url) : url_(std::move(url)) {}

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
    connection_.reset();
    return fail(ErrorCode::kUnavailable, "Postgres is unavailable");
  }

 private:
  static constexpr postgres::Patience kPatience{};

  pqxx::connection& connected() {
    if (!connection_) connection_ = postgres::connect(url_, "ingestd", kPatience, deadlines_);
    return *connection_;
  }

  std::string url_;
  SocketDeadlines deadlines_{};  ///< outlives the connection
  std::unique_ptr<pqxx::connection> connection_{};
  std::string last_state_{};  ///< SQLSTATE of the last error, to log a repeated one only once
};

}  // namespace diaphane::ingest
