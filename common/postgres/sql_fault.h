#pragma once

#include <pqxx/pqxx>
#include <string>
#include <string_view>

#include "common/log.h"

namespace diaphane::postgres {

/// Where a statement was run from, as a person finds it in the source.
struct CallSite {
  const char* file = "";
  int line = 0;
  static constexpr CallSite current(const char* file = __builtin_FILE(),
                                    int line = __builtin_LINE()) {
    return {file, line};
  }
};

/// "data_set_repository.cpp:40"
std::string to_string(CallSite where);

/// The constraint that an error of class 23 names, or "". `error` is Postgres's whole message; only
/// its first line is read, because the lines below it quote rows.
std::string constraint_in(std::string_view error, std::string_view sqlstate);

/// An SQL error that is a defect. Its text has the SQLSTATE, the constraint, and the statement by
/// its first words and the place of its transaction; Postgres's own message may quote what people
/// typed and is dropped.
class SqlFault : public log::SafeError {
 public:
  SqlFault(const pqxx::sql_error& error, CallSite where);
};

}  // namespace diaphane::postgres
