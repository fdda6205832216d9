#include "api/postgres/database.h"

#include <string_view>

#include "common/log.h"

namespace diaphane::api {
namespace {

constexpr auto kPatience = std::chrono::seconds(3);

std::string with_connect_timeout(const std::string& url) {
  if (url.find("://") == std::string::npos) {
    return url + " connect_timeout=2 application_name=diaphane-api";
  }
  return url + (url.find('?') == std::string::npos ? "?" : "&") +
         "connect_timeout=2&application_name=diaphane-api";
}

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
    : url_(with_connect_timeout(url)), limit_(static_cast<std::size_t>(connections)) {}

std::unique_ptr<pqxx::connection> Database::connect() const {
  auto connection = std::make_unique<pqxx::connection>(url_);
  // libpqxx 6 would quietly open a lost connection anew, without the settings below. (Deprecated
  // because 7 no longer does that.)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
  connection->inhibit_reactivation(true);
#pragma GCC diagnostic pop
  pqxx::nontransaction settings(*connection);
  settings.exec(
      "SET statement_timeout = '10s'; SET lock_timeout = '5s';"
      "SET idle_in_transaction_session_timeout = '30s'");
  return connection;
}

Database::Lease::Lease(Database& database) : database_(database) {
  std::unique_lock lock(database_.mutex_);
  granted_ = database_.freed_.wait_for(lock, kPatience,
                                       [&] { return database_.leased_ < database_.limit_; });
  if (!granted_) return;
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
    if (connection_) database_.idle_.push_back(std::move(connection_));
  }
  database_.freed_.notify_one();
}

pqxx::connection& Database::Lease::connection() {
  if (!connection_) connection_ = database_.connect();
  return *connection_;
}

Database::Mishap Database::judge(Lease& lease) {
  try {
    throw;
  } catch (const pqxx::broken_connection&) {
    lease.discard();
    return Mishap::kAway;
  } catch (const pqxx::in_doubt_error&) {
    // It may have been committed: never run again. The caller says "away" and the client asks how
    // things stand.
    lease.discard();
    log::warning("a commit is in doubt");
    return Mishap::kDefect;
  } catch (const pqxx::transaction_rollback&) {
    return Mishap::kAgain;
  } catch (const pqxx::sql_error& error) {
    // Shutting down or starting up (57P0x), out of connections, memory or disk (53), connection
    // (08), too slow (57014, 55P03).
    if (starts_with_any(error.sqlstate(), {"57", "53", "08", "55P03"})) {
      lease.discard();
      return Mishap::kAway;
    }
    log::error("SQL error", {{"sqlstate", error.sqlstate()}});
    return Mishap::kDefect;
  }
}

tl::unexpected<Error> Database::away() {
  return fail(ErrorCode::kUnavailable, "The database is away just now; try again shortly.");
}

tl::unexpected<Error> Database::all_in_use() {
  return fail(ErrorCode::kUnavailable, "Too much is going on just now; try again shortly.");
}

bool Database::reachable() {
  try {
    return transact([](pqxx::work& transaction) -> Result<void> {
             transaction.exec("SELECT 1");
             return {};
           })
        .has_value();
  } catch (...) {
    return false;
  }
}

}  // namespace diaphane::api
