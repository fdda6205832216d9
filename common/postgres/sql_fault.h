#pragma once

#include <pqxx/pqxx>
#include <string>
#include <string_view>

#include "common/log.h"

namespace diaphane::postgres {

/// The place in the source that ran a statement.
struct CallSite {
  const char* file = "";
  int line = 0;
  static constexpr CallSite current(const char* file = __builtin_FILE(),
                                    int line = __builtin_LINE()) {
    return {file, line};
  }
};

/// Formats the place, for example "data_set_repository.cpp:40".
std::string to_string(CallSite where);

/// Returns the constraint that an error of class 23 names, or "". Of Postgres's message in `error`,
/// only the first line is used, because the other lines quote rows.
std::string constraint_in(std::string_view error, std::string_view sqlstate);

/// An SQL error caused by a bug. Its text contains the SQLSTATE, the constraint, the first words of
/// the statement and the place of its transaction. Postgres's own message is dropped, because it
/// may quote user input.
class SqlFault : public log::SafeError {
 public:
  SqlFault(const pqxx::sql_error& error, CallSite where);
};

}  // namespace diaphane::postgres
