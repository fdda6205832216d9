#pragma once

#include <chrono>
#include <initializer_list>
#include <memory>
#include <pqxx/pqxx>
#include <string>
#include <utility>

#include "common/socket_deadlines.h"

namespace diaphane::postgres {

/// `url` (either of libpq's two forms) with further settings, which win over its own.
std::string with_settings(const std::string& url,
                          std::initializer_list<std::pair<const char*, std::string>> settings);

/// How long Postgres may take. `answer` bounds a whole transaction from this side, and holds also
/// when Postgres is frozen; the server ends its own work a little earlier by the other two, so that
/// a slow statement is told apart from a silent server.
struct Patience {
  std::chrono::milliseconds answer{5000};
  std::chrono::milliseconds statement{4000};
  std::chrono::milliseconds lock{3000};
};

/// Connects within two seconds per address and sets what every session of ours has. Error messages
/// come without their DETAIL, which quotes rows. Throws pqxx::broken_connection.
std::unique_ptr<pqxx::connection> connect(const std::string& url, const std::string& program,
                                          const Patience& patience, SocketDeadlines& deadlines);

}  // namespace diaphane::postgres
