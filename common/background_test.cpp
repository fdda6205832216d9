#include "common/background.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>

#include <thread>

namespace diaphane::background {
namespace {

int cores() {
  cpu_set_t allowed;
  return sched_getaffinity(0, sizeof allowed, &allowed) == 0 ? CPU_COUNT(&allowed) : 0;
}

TEST(Background, HasALowerPriorityAndTheGivenNumberOfCores) {
  const int all = cores(), nice = getpriority(PRIO_PROCESS, 0);
  limit_cores(1);
  std::thread([&] {
    enter(nice + 3);
    EXPECT_EQ(getpriority(PRIO_PROCESS, 0), nice + 3);
    EXPECT_EQ(cores(), 1);
    std::thread([] { EXPECT_EQ(cores(), 1); }).join();
  }).join();
  EXPECT_EQ(cores(), all) << "other threads keep theirs";
  limit_cores(0);
  std::thread([&] {
    enter(nice + 3);
    EXPECT_EQ(cores(), all);
  }).join();
}

TEST(Background, MayUseAllCoresIfMoreAreAllowed) {
  const int all = cores();
  limit_cores(static_cast<unsigned>(all) + 1);
  std::thread([&] {
    enter(0);
    EXPECT_EQ(cores(), all);
  }).join();
  limit_cores(0);
}

}  // namespace
}  // namespace diaphane::background
