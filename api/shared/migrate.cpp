#include "api/shared/migrate.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <pqxx/pqxx>
#include <set>
#include <sstream>

#include "common/postgres/sql_fault.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

constexpr const char* kLock = "SELECT pg_advisory_lock(4711820931)::text";
constexpr const char* kRecord = R"sql(
  CREATE TABLE IF NOT EXISTS schema_migrations (
    name        text PRIMARY KEY,
    applied_at  timestamptz NOT NULL DEFAULT now()
  ))sql";

Result<std::vector<std::string>> names_in(const std::string& directory) {
  std::error_code error;
  std::vector<std::string> names;
  constexpr std::string_view kSuffix = ".up.sql";
  for (const auto& entry : std::filesystem::directory_iterator(directory, error)) {
    const std::string file = entry.path().filename().string();
    if (file.ends_with(kSuffix)) names.push_back(file.substr(0, file.size() - kSuffix.size()));
  }
  if (error) return fail(ErrorCode::kInvalid, "cannot read the migrations directory");
  if (names.empty())
    return fail(ErrorCode::kInvalid, "the migrations directory contains no migrations");
  std::sort(names.begin(), names.end());
  return names;
}

Result<std::string> text_of(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) return fail(ErrorCode::kInvalid, path + " cannot be read");
  return text.str();
}

}  // namespace

Result<std::vector<std::string>> migrate(const std::string& url, const std::string& directory,
                                         Direction direction, int steps) {
  const auto names = names_in(directory);
  DIAPHANE_TRY(names);
  std::string current;
  try {
    pqxx::connection connection(url);
    // Omits DETAIL, which quotes rows: "Key (email_key)=(...) is duplicated."
    connection.set_verbosity(pqxx::connection_base::terse);
    std::set<std::string> applied;
    {
      pqxx::nontransaction session(connection);
      session.exec("SET client_min_messages = warning");
      session.exec(kLock);  // until the connection closes
      session.exec(kRecord);
      for (const pqxx::row& row : session.exec("SELECT name FROM schema_migrations")) {
        applied.insert(row["name"].as<std::string>());
      }
    }
    std::vector<std::string> todo;
    for (const std::string& name : *names) {
      if (applied.contains(name) == (direction == Direction::kDown)) todo.push_back(name);
    }
    if (direction == Direction::kDown) {
      std::reverse(todo.begin(), todo.end());
      if (steps == 0) steps = 1;
    }
    if (steps > 0 && static_cast<std::size_t>(steps) < todo.size()) {
      todo.resize(static_cast<std::size_t>(steps));
    }
    for (const std::string& name : todo) {
      current = name;
      const char* suffix = direction == Direction::kUp ? ".up.sql" : ".down.sql";
      const auto sql = text_of(directory + "/" + name + suffix);
      DIAPHANE_TRY(sql);
      pqxx::work transaction(connection);
      transaction.exec(*sql);
      if (direction == Direction::kUp) {
        transaction.exec_params0("INSERT INTO schema_migrations (name) VALUES ($1)", name);
      } else {
        transaction.exec_params0("DELETE FROM schema_migrations WHERE name = $1", name);
      }
      transaction.commit();
    }
    return todo;
  } catch (const pqxx::broken_connection& error) {
    return fail(ErrorCode::kUnavailable,
                std::string("the database is unavailable: ") + error.what());
  } catch (const pqxx::sql_error& error) {
    // Errors of class 42 quote only the text of the migration.
    const bool of_text = error.sqlstate().starts_with("42");
    return fail(ErrorCode::kInvalid,
                "migration " + current + ": " +
                    (of_text ? std::string(error.what())
                             : postgres::SqlFault(error, postgres::CallSite::current()).what()));
  } catch (const pqxx::failure& error) {
    return fail(ErrorCode::kInvalid, "migration " + current + ": " + log::describe(error));
  }
}

}  // namespace diaphane::api
