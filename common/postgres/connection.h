#pragma once

#include <chrono>
#include <initializer_list>
#include <memory>
#include <pqxx/pqxx>
#include <string>
#include <utility>

#include "common/socket_deadlines.h"

namespace diaphane::postgres {

/// Returns `url` (in either of libpq's forms) with extra settings, which override its own.
std::string with_settings(const std::string& url,
                          std::initializer_list<std::pair<const char*, std::string>> settings);

/// Timeouts for Postgres. `answer` bounds a whole transaction on the client side, even when
/// Postgres is frozen. The other two make the server stop a little earlier, so that a slow
/// statement can be distinguished from a server that does not respond.
struct Patience {
  std::chrono::milliseconds answer{5000};
  std::chrono::milliseconds statement{4000};
  std::chrono::milliseconds lock{3000};
};

/// Connects within two seconds per address and applies the session settings that we always use.
/// Error messages omit DETAIL, which quotes rows. Throws pqxx::broken_connection.
std::unique_ptr<pqxx::connection> connect(const std::string& url, const std::string& program,
                                          const Patience& patience, SocketDeadlines& deadlines);

}  // namespace diaphane::postgres
