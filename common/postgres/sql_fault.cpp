#include "common/postgres/sql_fault.h"

#include <algorithm>
#include <cctype>

namespace diaphane::postgres {
namespace {

bool is_name_part(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

/// Returns the first words of a statement ("UPDATE users SET"). Stops before anything that could be
/// a value, so the result has only keywords and names of tables.
std::string first_words(std::string_view statement) {
  constexpr int kWords = 3;
  std::string words;
  std::size_t at = 0;
  for (int i = 0; i < kWords; ++i) {
    while (at < statement.size() && std::isspace(static_cast<unsigned char>(statement[at]))) ++at;
    const std::size_t begin = at;
    while (at < statement.size() && is_name_part(statement[at])) ++at;
    if (at == begin) break;
    if (!words.empty()) words += ' ';
    words += statement.substr(begin, at - begin);
  }
  return words;
}

std::string text_of(const pqxx::sql_error& error, CallSite where) {
  std::string text = "SQLSTATE " + (error.sqlstate().empty() ? "unknown" : error.sqlstate());
  if (const auto constraint = constraint_in(error.what(), error.sqlstate()); !constraint.empty()) {
    text += ", constraint " + constraint;
  }
  text += ", statement " + first_words(error.query());
  return text + ", transaction " + to_string(where);
}

}  // namespace

std::string to_string(CallSite where) {
  const std::string_view path = where.file;
  return std::string(path.substr(path.rfind('/') + 1)) + ":" + std::to_string(where.line);
}

std::string constraint_in(std::string_view error, std::string_view sqlstate) {
  if (!sqlstate.starts_with("23")) return {};
  const std::string_view line = error.substr(0, error.find('\n'));
  // Takes the last quoted name of 'new row for relation "users" violates check constraint
  // "users_email_check"'.
  const std::size_t end = line.rfind('"');
  if (end == std::string_view::npos || end == 0) return {};
  const std::size_t begin = line.rfind('"', end - 1);
  if (begin == std::string_view::npos) return {};
  const std::string_view name = line.substr(begin + 1, end - begin - 1);
  return std::all_of(name.begin(), name.end(), is_name_part) ? std::string(name) : std::string();
}

SqlFault::SqlFault(const pqxx::sql_error& error, CallSite where)
    : SafeError(text_of(error, where)) {}

}  // namespace diaphane::postgres
