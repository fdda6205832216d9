#include "ingest/pipeline/memory_shortage.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <memory>
#include <new>
#include <vector>

namespace diaphane::ingest {
namespace {

constexpr int kShort = 71, kRefused = 11, kGot = 10;
constexpr std::size_t kMb = std::size_t{1} << 20;

/// Returns how a process ends that allocates `bytes` under a limit.
int asks(std::size_t bytes, __rlimit_resource resource, std::size_t most) {
  const pid_t child = fork();
  if (child == 0) {
    end_when_machine_is_short_of_memory(kShort);
    const rlimit limit{most, most};
    if (setrlimit(resource, &limit) != 0) _exit(1);
    try {
      const std::vector<char> got(bytes, 'x');
      _exit(got[bytes / 2] == 'x' ? kGot : 1);
    } catch (const std::bad_alloc&) {
      _exit(kRefused);
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

class MemoryShortage : public ::testing::Test {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers have their own operator new";
#endif
  }
};

TEST_F(MemoryShortage, ExceedingOwnLimitThrowsBadAlloc) {
  EXPECT_EQ(asks(900 * kMb, RLIMIT_AS, 600 * kMb), kRefused);
}

/// A limit on writable memory alone simulates a machine with too little memory.
TEST_F(MemoryShortage, ExitsWhenTheMachineIsOutOfMemory) {
  EXPECT_EQ(asks(900 * kMb, RLIMIT_DATA, 600 * kMb), kShort);
  EXPECT_EQ(asks(100 * kMb, RLIMIT_DATA, 600 * kMb), kGot);
}

TEST_F(MemoryShortage, DistinguishesSmallAllocationsAtTheLimitToo) {
  for (const auto& [resource, end] :
       {std::pair(RLIMIT_AS, kRefused), std::pair(RLIMIT_DATA, kShort)}) {
    const pid_t child = fork();
    if (child == 0) {
      end_when_machine_is_short_of_memory(kShort);
      const rlimit limit{300 * kMb, 300 * kMb};
      if (setrlimit(resource, &limit) != 0) _exit(1);
      try {
        std::vector<std::unique_ptr<std::vector<char>>> held;
        for (;;) held.push_back(std::make_unique<std::vector<char>>(100));
      } catch (const std::bad_alloc&) {
        _exit(kRefused);
      }
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), end);
  }
}

}  // namespace
}  // namespace diaphane::ingest
