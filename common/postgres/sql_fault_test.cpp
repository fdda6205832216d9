#include "common/postgres/sql_fault.h"

#include <gtest/gtest.h>

namespace diaphane::postgres {
namespace {

TEST(SqlFault, ReportsStateConstraintAndStatementWithoutValues) {
  const pqxx::sql_error error(
      "ERROR:  duplicate key value violates unique constraint \"users_email_key_key\"\n"
      "DETAIL:  Key (email_key)=(somebody@example.org) already exists.\n",
      "\n  UPDATE users SET email = 'somebody@example.org' WHERE id = $1", "23505");
  const std::string text = SqlFault(error, {"api/scans/some_repository.cpp", 12}).what();
  EXPECT_EQ(text,
            "SQLSTATE 23505, constraint users_email_key_key, statement UPDATE users SET, "
            "transaction some_repository.cpp:12");
}

TEST(SqlFault, IgnoresConstraintNamesThatMayBeValues) {
  EXPECT_EQ(constraint_in("ERROR:  invalid input syntax for type uuid: \"somebody\"", "22P02"), "");
  EXPECT_EQ(constraint_in("ERROR:  duplicate key\nDETAIL:  Key (name)=(\"somebody\")", "23505"),
            "");
  EXPECT_EQ(constraint_in("ERROR:  breaks constraint \"some body@example.org\"", "23505"), "");
  EXPECT_EQ(constraint_in("", "23505"), "");
}

TEST(SqlFault, TruncatesStatementBeforeItsFirstValue) {
  const pqxx::sql_error error("ERROR:  x", "SELECT 'somebody@example.org'", "42601");
  EXPECT_EQ(std::string(SqlFault(error, {"a.cpp", 1}).what()),
            "SQLSTATE 42601, statement SELECT, transaction a.cpp:1");
}

}  // namespace
}  // namespace diaphane::postgres
