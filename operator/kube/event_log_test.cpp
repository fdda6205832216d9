#include "operator/kube/event_log.h"

#include <gtest/gtest.h>

namespace diaphane::kube {
namespace {

using namespace std::chrono_literals;
using Time = EventLog::Time;

Happened draining(const std::string& uid, const std::string& message) {
  return {"RenderWorker", "w-" + uid, uid, "Draining", message, false};
}

TEST(EventLog, AggregatesRepeatedEventsAndWritesTheCountEveryTenSeconds) {
  EventLog log("run");
  const auto first = log.note(draining("1", "x"), Time{});
  ASSERT_TRUE(first);
  EXPECT_EQ(first->count, 1);
  int writes = 0, count = 0;
  for (int t = 1; t <= 60; ++t) {
    if (const auto more = log.note(draining("1", "x"), Time{} + std::chrono::seconds(t))) {
      ++writes;
      count = more->count;
      EXPECT_EQ(more->name, first->name);
    }
  }
  EXPECT_EQ(writes, 6);
  EXPECT_EQ(count, 61);
}

TEST(EventLog, SeparatesEventsByObjectAndMessage) {
  EventLog log("run");
  const auto a = log.note(draining("1", "x"), Time{});
  const auto b = log.note(draining("2", "x"), Time{});
  const auto c = log.note(draining("1", "y"), Time{});
  ASSERT_TRUE(a && b && c);
  EXPECT_NE(a->name, b->name);
  EXPECT_NE(a->name, c->name);
}

TEST(EventLog, RateLimitsEventsPerObject) {
  EventLog log("run");
  int written = 0;
  for (int i = 0; i < 1000; ++i) {
    written += log.note(draining("1", std::to_string(i)), Time{}).has_value();
  }
  EXPECT_EQ(written, EventLog::kBurst);
  EXPECT_TRUE(log.note(draining("1", "later"), Time{} + 60s));
  EXPECT_TRUE(log.note(draining("2", "x"), Time{}));
}

TEST(EventLog, ForgetsOldEvents) {
  EventLog log("run");
  for (int i = 0; i < 100; ++i) log.note(draining(std::to_string(i), "x"), Time{});
  EXPECT_EQ(log.remembered(), 100U);
  log.note(draining("1", "y"), Time{} + 1h);
  EXPECT_EQ(log.remembered(), 1U);
}

}  // namespace
}  // namespace diaphane::kube
