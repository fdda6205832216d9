#include "common/postgres/address.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "common/postgres/connection.h"

namespace diaphane::postgres {
namespace {

class PostgresAddress : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : kNames) unsetenv(name);
    setenv("PGSERVICEFILE", "/nonexistent", 1);
    setenv("PGSYSCONFDIR", "/nonexistent", 1);
  }
  void TearDown() override {
    for (const char* name : kNames) unsetenv(name);
  }
  static bool usable(const std::string& url) { return may_be_used(url, false).has_value(); }

 private:
  static constexpr const char* kNames[] = {"PGHOST",    "PGHOSTADDR",    "PGSSLMODE",
                                           "PGSERVICE", "PGSERVICEFILE", "PGSYSCONFDIR"};
};

TEST_F(PostgresAddress, AllowsLocalAddressesWithoutTls) {
  for (const char* url :
       {"postgresql://u:p@127.0.0.1:5432/d", "postgres://localhost/d", "postgresql://[::1]/d",
        "postgresql:///d", "", "dbname=d", "host=/run/postgresql dbname=d", "host=@abstract",
        "postgresql://%2Frun%2Fpostgresql/d", "host=127.0.0.1,localhost", "hostaddr=127.0.0.2",
        "host=db.example.org hostaddr=127.0.0.1", "host=db.example.org,/run hostaddr=::1,"}) {
    EXPECT_TRUE(usable(url)) << url;
  }
}

TEST_F(PostgresAddress, RefusesRemoteAddressesWithoutVerifiedTls) {
  for (const char* url :
       {"postgresql://u:p@10.0.0.1/d", "postgres://db.example.org:5432/d",
        "postgresql://u@/d?host=db.example.org", "postgresql:///d?hostaddr=10.0.0.1",
        "host=db.example.org dbname=d", "host = 'db.example.org'", "hostaddr=10.0.0.1",
        "host=127.0.0.1,db.example.org", "host=localhost hostaddr=10.0.0.1",
        "hostaddr=127.0.0.1, host=localhost,db.example.org", "postgresql://[2001:db8::1]/d",
        "postgresql://localhost,db.example.org/d", "host=db sslmode=prefer",
        "host=db sslmode=require", "postgresql://db/d?sslmode=disable",
        "postgresql://db/d?ssl=true", "host=localhost.example.org"}) {
    EXPECT_FALSE(usable(url)) << url;
    EXPECT_TRUE(may_be_used(url, true).has_value()) << url;
  }
}

TEST_F(PostgresAddress, AllowsRemoteAddressesWithVerifiedTls) {
  EXPECT_TRUE(usable("postgresql://db.example.org/d?sslmode=verify-full"));
  EXPECT_TRUE(usable("host=db.example.org sslmode=verify-ca"));
}

TEST_F(PostgresAddress, ReadsEnvironmentVariables) {
  setenv("PGHOST", "db.example.org", 1);
  EXPECT_FALSE(usable("dbname=d"));
  EXPECT_TRUE(usable("host=localhost dbname=d"));
  setenv("PGSSLMODE", "verify-full", 1);
  EXPECT_TRUE(usable("dbname=d"));
  EXPECT_FALSE(usable("dbname=d sslmode=prefer"));
  setenv("PGHOSTADDR", "10.0.0.1", 1);
  setenv("PGSSLMODE", "disable", 1);
  EXPECT_FALSE(usable("host=localhost"));
}

TEST_F(PostgresAddress, ReadsServiceFile) {
  const std::string path = testing::TempDir() + "/diaphane_pg_service.conf";
  std::ofstream(path) << "[far]\nhost=db.example.org\n[safe]\nhost=db.example.org\n"
                         "sslmode=verify-full\n";
  setenv("PGSERVICEFILE", path.c_str(), 1);
  EXPECT_FALSE(usable("service=far"));
  EXPECT_FALSE(usable("postgresql:///d?service=far"));
  EXPECT_TRUE(usable("service=safe"));
  EXPECT_TRUE(usable("service=far host=localhost"));
  EXPECT_EQ(getenv("PGSERVICE"), nullptr);
  setenv("PGSERVICE", "far", 1);
  EXPECT_FALSE(usable("dbname=d"));
  EXPECT_TRUE(usable("service=safe"));
  EXPECT_STREQ(getenv("PGSERVICE"), "far");
}

TEST_F(PostgresAddress, ParseErrorDoesNotQuoteTheAddress) {
  const auto refused = may_be_used("postgresql://u:hidden@localhost/d?nonsense=1", false);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().message.find("hidden"), std::string::npos);
}

TEST_F(PostgresAddress, AddsSettingsToUrlsAndKeywordStrings) {
  EXPECT_EQ(
      with_settings("postgresql://u:p%27%5C@h/d?connect_timeout=9", {{"connect_timeout", "2"}}),
      R"(connect_timeout='2' dbname='d' host='h' password='p\'\\' user='u')");
  EXPECT_EQ(with_settings("host=h", {{"application_name", "a b"}}),
            "application_name='a b' host='h'");
}

}  // namespace
}  // namespace diaphane::postgres
