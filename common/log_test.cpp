#include "common/log.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>

namespace diaphane {
namespace {

nlohmann::json line_with(const std::string& text) {
  testing::internal::CaptureStderr();
  log::error("test", {{"reason", text}, {"count", 1}});
  return nlohmann::json::parse(testing::internal::GetCapturedStderr());
}

TEST(Log, WritesOneJsonObjectPerLineForAnyText) {
  const auto line = line_with("quote \" line\nfeed \x01 and \xff, which is not UTF-8");
  EXPECT_EQ(line["event"], "test");
  EXPECT_EQ(line["level"], "error");
  EXPECT_EQ(line["count"], 1);
}

TEST(Log, TruncatesLongText) {
  EXPECT_EQ(line_with(std::string(2048, 'x'))["reason"], std::string(2048, 'x'));
  EXPECT_EQ(line_with(std::string(1 << 20, 'x'))["reason"], std::string(2048, 'x') + "…");
  // The limit cuts a character of two bytes.
  const auto cut = line_with("x" + std::string(2046, 'x') + "éé")["reason"].get<std::string>();
  EXPECT_TRUE(cut.starts_with(std::string(2047, 'x')));
  EXPECT_LT(cut.size(), 2060U);
}

TEST(Log, DescribesExceptionByTypeWithoutItsText) {
  EXPECT_EQ(log::describe(std::runtime_error("Key (email_key)=(somebody@example.org)")),
            "std::runtime_error");
  EXPECT_EQ(log::describe(std::system_error(2, std::generic_category(), "/scans/somebody")),
            "std::system_error, generic 2");
  EXPECT_EQ(log::describe(log::SafeError("response over 1 MB")), "response over 1 MB");
}

TEST(LogDeathTest, LogsUncaughtExceptionWithoutItsText) {
  const auto ends = [] {
    log::start("test");
    std::thread([] { throw std::runtime_error("somebody@example.org"); }).join();
  };
  EXPECT_DEATH(ends(), R"(^\{[^@]*"event":"terminated","reason":"std::runtime_error"\}\s*$)");
}

}  // namespace
}  // namespace diaphane
