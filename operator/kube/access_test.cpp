#include "operator/kube/access.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "operator/kube/api.h"

namespace diaphane::kube {
namespace {

using namespace std::chrono_literals;

class AccessTest : public testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/diaphane-test-XXXXXX";
    folder_ = mkdtemp(name);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ + "/" + name) << text;
  }
  std::string folder_;
};

TEST_F(AccessTest, ReadsInClusterConfiguration) {
  write("namespace", "clinic\n");
  const auto access = access_of_pod(
      {{"KUBERNETES_SERVICE_HOST", "fd00::1"}, {"KUBERNETES_SERVICE_PORT", "6443"}}, folder_);
  ASSERT_TRUE(access);
  EXPECT_EQ(access->server, "https://[fd00::1]:6443");
  EXPECT_EQ(access->name_space, "clinic");
  EXPECT_EQ(access->token_file, folder_ + "/token");
  EXPECT_FALSE(access_of_pod({}, folder_));
}

TEST_F(AccessTest, ReloadsTokenAfterAMinuteOrARefusal) {
  write("token", "one\n");
  Token token(folder_ + "/token");
  const Token::Time begin{};
  EXPECT_EQ(token.at(begin), "one");
  write("token", "two");
  EXPECT_EQ(token.at(begin + 59s), "one");
  EXPECT_EQ(token.at(begin + 60s), "two");
  write("token", "three");
  token.refused();
  EXPECT_EQ(token.at(begin + 61s), "three");
  std::filesystem::remove(folder_ + "/token");
  EXPECT_EQ(token.at(begin + 10min), "three");
}

TEST(Times, ParseAndFormatRfc3339) {
  EXPECT_EQ(time_text(0.25), "1970-01-01T00:00:00.250000Z");
  EXPECT_EQ(time_text(0.99999999), "1970-01-01T00:00:01.000000Z");
  EXPECT_EQ(time_of("2026-11-22T15:04:05Z"), 1795359845.0);
  EXPECT_EQ(time_of("2026-11-22T16:04:05+01:00"), 1795359845.0);
  EXPECT_EQ(time_of("words"), std::nullopt);
  EXPECT_EQ(time_of("2026-11-22T15:04:05"), std::nullopt);
  EXPECT_NEAR(*time_of(time_text(1795359845.123456)), 1795359845.123456, 1e-6);
}

TEST(ApiErrors, KeepTheReasonOfTheServer) {
  const Error error =
      error_of(409, {{"reason", "AlreadyExists"}, {"message", "pods \"a\" already exists"}});
  EXPECT_EQ(error.code, ErrorCode::kConflict);
  EXPECT_EQ(error.field, "AlreadyExists");
  EXPECT_EQ(error_of(503, nlohmann::json()).code, ErrorCode::kUnavailable);
  EXPECT_EQ(error_of(403, "words").code, ErrorCode::kForbidden);
}

}  // namespace
}  // namespace diaphane::kube
