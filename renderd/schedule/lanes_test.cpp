#include "renderd/schedule/lanes.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <latch>

namespace diaphane::render {
namespace {

TEST(Lanes, DestructorRunsEveryJobOnce) {
  for (const std::size_t most : {0, 1, 3, 8}) {
    std::atomic<int> calls{0};
    {
      Lanes lanes(most);
      for (int i = 0; i < 50; ++i) lanes.start([&] { ++calls; });
    }
    EXPECT_EQ(calls, 50);
  }
}

TEST(Lanes, RunJobsConcurrently) {
  std::latch all(3);  // passed only once all three are here
  Lanes lanes(3);
  for (int i = 0; i < 3; ++i) lanes.start([&] { all.arrive_and_wait(); });
}

TEST(Lanes, OneLaneKeepsTheOrder) {
  std::vector<int> order;
  {
    Lanes lanes(1);
    for (int i = 0; i < 20; ++i) lanes.start([&, i] { order.push_back(i); });
  }
  for (int i = 0; i < 20; ++i) EXPECT_EQ(order.at(static_cast<std::size_t>(i)), i);
}

TEST(Lanes, ThreadsHaveTheNiceValueOfTheLanes) {
  const int own = getpriority(PRIO_PROCESS, 0);
  int found = -1;
  {
    Lanes lanes(1, own + 3);
    lanes.start([&] { found = getpriority(PRIO_PROCESS, 0); });
  }
  EXPECT_EQ(found, std::min(own + 3, 19));
}

}  // namespace
}  // namespace diaphane::render
