#include "operator/kube/work_queue.h"

#include <gtest/gtest.h>

namespace diaphane::kube {
namespace {

using namespace std::chrono_literals;
using Time = WorkQueue::Time;

TEST(WorkQueue, DeduplicatesKeys) {
  WorkQueue queue;
  queue.put("a", Time{});
  queue.put("a", Time{});
  EXPECT_EQ(queue.take(Time{}), "a");
  queue.done("a");
  EXPECT_EQ(queue.take(Time{} + 1h), std::nullopt);
}

TEST(WorkQueue, GivesAKeyToOneWorkerAtATime) {
  WorkQueue queue;
  queue.put("a", Time{});
  EXPECT_EQ(queue.take(Time{}), "a");
  queue.put("a", Time{});
  EXPECT_EQ(queue.take(Time{} + 1h), std::nullopt);
  queue.done("a");
  EXPECT_EQ(queue.take(Time{} + 1h), "a");
}

TEST(WorkQueue, ReschedulesKeyButNotBeforeItsBackoffEnds) {
  WorkQueue queue;
  queue.put("a", Time{});
  queue.put("b", Time{} + 1s);
  queue.put("a", Time{} + 2s);
  EXPECT_EQ(queue.take(Time{} + 1h), "b");
  EXPECT_EQ(queue.take(Time{} + 1h), "a");
  queue.failed("a", Time{} + 1h);
  queue.done("a");
  queue.put("a", Time{} + 1h);
  EXPECT_EQ(queue.take(Time{} + 1h), std::nullopt);
  EXPECT_EQ(queue.take(Time{} + 1h + WorkQueue::kFirst), "a");
}

TEST(WorkQueue, ReturnsLongestDueKeyFirst) {
  WorkQueue queue;
  queue.put("late", Time{} + 2s);
  queue.put("soon", Time{} + 1s);
  EXPECT_EQ(queue.take(Time{}), std::nullopt);
  EXPECT_EQ(queue.next(), Time{} + 1s);
  EXPECT_EQ(queue.take(Time{} + 3s), "soon");
  EXPECT_EQ(queue.take(Time{} + 3s), "late");
}

TEST(WorkQueue, RetriesFailedKeyWithIncreasingBackoff) {
  WorkQueue queue;
  Time now{};
  std::chrono::milliseconds pause = 5ms;
  for (int i = 0; i < 20; ++i) {
    queue.put("a", now);
    now = std::max(now, queue.next().value_or(now));
    ASSERT_EQ(queue.take(now), "a");
    queue.failed("a", now);
    queue.done("a");
    // Neither a new reason nor frequent polling shortens its pause.
    queue.put("a", now);
    EXPECT_EQ(queue.next(), now + pause) << i;
    EXPECT_EQ(queue.take(now + pause - 1ms), std::nullopt);
    pause = std::min(2 * pause, WorkQueue::kLongest);
  }
  EXPECT_EQ(pause, 1000s);
}

TEST(WorkQueue, SuccessResetsFailuresOfThatKeyOnly) {
  WorkQueue queue;
  for (const char* key : {"a", "b"}) {
    queue.put(key, Time{});
    ASSERT_EQ(queue.take(Time{}), key);
    queue.failed(key, Time{});
    queue.done(key);
  }
  ASSERT_EQ(queue.take(Time{} + 1s), "a");
  queue.forget("a");
  queue.done("a");
  EXPECT_EQ(queue.failures("a"), 0);
  EXPECT_EQ(queue.failures("b"), 1);
}

}  // namespace
}  // namespace diaphane::kube
