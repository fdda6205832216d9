#include "common/log.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace diaphane {
namespace {

nlohmann::json line_with(const std::string& text) {
  testing::internal::CaptureStderr();
  log::error("test", {{"reason", text}, {"count", 1}});
  return nlohmann::json::parse(testing::internal::GetCapturedStderr());
}

TEST(Log, ALineIsOneJsonObjectWhateverItsTextsHold) {
  const auto line = line_with("quote \" line\nfeed \x01 and \xff, which is not UTF-8");
  EXPECT_EQ(line["event"], "test");
  EXPECT_EQ(line["level"], "error");
  EXPECT_EQ(line["count"], 1);
}

TEST(Log, ALongTextIsCutOff) {
  EXPECT_EQ(line_with(std::string(2048, 'x'))["reason"], std::string(2048, 'x'));
  EXPECT_EQ(line_with(std::string(1 << 20, 'x'))["reason"], std::string(2048, 'x') + "…");
  // The cut goes through a character of two bytes.
  const auto cut = line_with("x" + std::string(2046, 'x') + "éé")["reason"].get<std::string>();
  EXPECT_TRUE(cut.starts_with(std::string(2047, 'x')));
  EXPECT_LT(cut.size(), 2060U);
}

}  // namespace
}  // namespace diaphane
