#include "api/accounts/attempts.h"

#include <gtest/gtest.h>

#include <tuple>

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;

TEST(Attempts, RefusalStatesWaitInWholeMinutes) {
  for (const auto& [wait, words, retry] :
       {std::tuple(0s, "in 1 minute.", 1s), std::tuple(1s, "in 1 minute.", 1s),
        std::tuple(60s, "in 1 minute.", 60s), std::tuple(61s, "in 2 minutes.", 61s),
        std::tuple(900s, "in 15 minutes.", 900s)}) {
    const Problem refused = too_many_attempts(wait).value();
    EXPECT_EQ(refused.kind, ProblemKind::kTooManyAttempts);
    EXPECT_NE(refused.detail.find(words), std::string::npos) << refused.detail;
    EXPECT_EQ(refused.retry_after, retry);
  }
}

TEST(Attempts, AreCountedByKindAndSource) {
  const std::string key = attempt_key("account", "a@b");
  EXPECT_EQ(attempt_key("account", "a@b"), key);
  EXPECT_NE(attempt_key("address", "a@b"), key);
  EXPECT_NE(attempt_key("account", "a@c"), key);
  EXPECT_EQ(key.find("a@b"), std::string::npos);
}

}  // namespace
}  // namespace diaphane::api
