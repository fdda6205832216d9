#include "api/shared/database.h"

#include <string_view>

#include "common/log.h"

namespace diaphane::api {
namespace {

/// Connecting takes milliseconds, and a refusal is immediate. An attempt that fails after a longer
/// time than this means that the server did not respond.
constexpr auto kConnectingIsSilence = std::chrono::milliseconds(900);

bool starts_with_any(std::string_view state, std::initializer_list<std::string_view> prefixes) {
  for (const std::string_view prefix : prefixes) {
    if (state.substr(0, prefix.size()) == prefix) return true;
  }
  return false;
}

}  // namespace

std::int64_t to_us(Time time) {
  return std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count();
}

Time from_us(std::int64_t us) { return Time(std::chrono::microseconds(us)); }

Database::Database(std::string url, int connections)
    : url_(std::move(url)), limit_(static_cast<std::size_t>(connections)) {}

Database::Lease::Lease(Database& database, std::chrono::milliseconds patience)
    : database_(database) {
  std::unique_lock lock(database_.mutex_);
  const bool free = database_.freed_.wait_for(
      lock, patience, [&] { return database_.silent_ || database_.leased_ < database_.limit_; });
  if (!free || database_.leased_ >= database_.limit_) return;
  if (database_.silent_) {
    if (database_.probing_) return;
    database_.probing_ = probe_ = true;
  }
  granted_ = true;
  ++database_.leased_;
  if (!database_.idle_.empty()) {
    connection_ = std::move(database_.idle_.back());
    database_.idle_.pop_back();
    reused_ = true;
  }
}

Database::Lease::~Lease() {
  if (!granted_) return;
  {
    const std::lock_guard lock(database_.mutex_);
    --database_.leased_;
    if (probe_) database_.probing_ = false;
    if (answered_ && database_.silent_) {
      database_.silent_ = false;
      log::info("postgres_responsive");
    }
    if (connection_) database_.idle_.push_back(std::move(connection_));
  }
  database_.freed_.notify_one();
}

void Database::Lease::silent() {
  discard();
  std::vector<std::unique_ptr<pqxx::connection>> in_doubt;  // closed outside the lock
  {
    const std::lock_guard lock(database_.mutex_);
    if (!database_.silent_) log::warning("postgres_unresponsive");
    database_.silent_ = true;
    in_doubt.swap(database_.idle_);
  }
  database_.freed_.notify_all();  // ends all waits for a connection
}

pqxx::connection& Database::Lease::connection() {
  if (connection_) return *connection_;
  const auto begun = std::chrono::steady_clock::now();
  try {
    connection_ = postgres::connect(database_.url_, "api", kPatience, database_.deadlines_);
  } catch (const pqxx::broken_connection&) {
    if (std::chrono::steady_clock::now() - begun > kConnectingIsSilence) silent();
    throw;
  }
  return *connection_;
}

Database::FailureKind Database::judge(Lease& lease, CallSite where) {
  try {
    throw;
  } catch (const pqxx::broken_connection&) {
    lease.discard();
    return FailureKind::kUnavailable;
  } catch (const pqxx::in_doubt_error&) {
    // The transaction may have been committed, so it must not be repeated.
    lease.discard();
    log::warning("commit_in_doubt");
    return FailureKind::kCommitUnknown;
  } catch (const pqxx::statement_completion_unknown&) {
    lease.discard();
    log::warning("commit_in_doubt");
    return FailureKind::kCommitUnknown;
  } catch (const pqxx::transaction_rollback&) {
    lease.answered();
    return FailureKind::kRetry;
  } catch (const pqxx::unexpected_rows&) {
    // A required row has been deleted in the meantime, for example with the account.
    lease.answered();
    return FailureKind::kConflict;
  } catch (const pqxx::sql_error& error) {
    lease.answered();
    // The server is shutting down or starting up (57P0x), is out of connections, memory or disk
    // space (53), has an I/O error (58), lost the connection (08), was too slow (57014, 55P03),
    // ended an idle transaction (25P03) or is a standby (25006).
    if (starts_with_any(error.sqlstate(), {"57", "53", "58", "08", "55P03", "25P03", "25006"})) {
      lease.discard();
      return FailureKind::kUnavailable;
    }
    // Concurrent transactions checked the same rule, and the second one broke a constraint. When it
    // runs again, it sees the changes of the first.
    if (starts_with_any(error.sqlstate(), {"23503", "23505", "23514"})) {
      log::info("sql_conflict", {{"reason", postgres::SqlFault(error, where).what()}});
      return FailureKind::kConflict;
    }
    throw postgres::SqlFault(error, where);
  }
}

tl::unexpected<Error> Database::not_granted() {
  const std::lock_guard lock(mutex_);
  if (silent_) return away();
  return fail(ErrorCode::kUnavailable, "The service is busy. Please try again in a moment.");
}

tl::unexpected<Error> Database::away() {
  return fail(ErrorCode::kUnavailable,
              "The service is temporarily unavailable. Please try again in a moment.");
}

tl::unexpected<Error> Database::outcome_unknown() {
  return fail(ErrorCode::kOutcomeUnknown,
              "The connection to the database was lost while your change was being saved. It may "
              "or may not have been saved. Check before you try again.");
}

tl::unexpected<Error> Database::conflict(CallSite where) {
  log::error("sql_conflict_persists", {{"transaction", postgres::to_string(where)}});
  return fail(ErrorCode::kConflict,
              "Data that this request needs was changed or deleted at the same time. Reload and "
              "try again.");
}

bool Database::reachable() {
  const auto ask = [](pqxx::work& transaction) -> Result<void> {
    transaction.exec("SELECT 1");
    return {};
  };
  try {
    return run(ask, false, kProbe, CallSite::current()).has_value();
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace diaphane::api
