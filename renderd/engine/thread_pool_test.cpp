#include "renderd/engine/thread_pool.h"

#include <gtest/gtest.h>

#include <array>
#include <latch>

namespace diaphane::render {
namespace {

TEST(ThreadPool, EachPieceIsDoneOnce) {
  ThreadPool pool(4);
  for (const std::uint32_t count : {0u, 1u, 3u, 64u, 1000u}) {
    std::vector<std::atomic<int>> calls(count);
    EXPECT_TRUE(pool.run(count, [&](std::uint32_t i) { ++calls[i]; }));
    for (const auto& each : calls) EXPECT_EQ(each, 1);
  }
}

TEST(ThreadPool, WhatIsNotBegunIsLeftOutWhenStopped) {
  ThreadPool pool(1);  // with others, they may have done all before it is asked
  std::atomic<int> done{0};
  EXPECT_FALSE(pool.run(
      1000, [&](std::uint32_t) { ++done; }, [&] { return done >= 10; }));
  EXPECT_LT(done, 1000);
}

TEST(ThreadPool, LoopsOfTwoCallersGoOnAtOnce) {
  ThreadPool pool(1);  // no thread but the callers'
  std::latch both(2);
  const auto loop = [&] { pool.run(1, [&](std::uint32_t) { both.arrive_and_wait(); }); };
  std::thread other(loop);
  loop();
  other.join();
}

TEST(ThreadPool, ManyCallersGetEachOfTheirPiecesOnce) {
  ThreadPool pool(3);
  std::array<std::atomic<int>, 4> sums{};
  std::vector<std::thread> callers;
  for (std::size_t c = 0; c < sums.size(); ++c) {
    callers.emplace_back([&, c] {
      for (int i = 0; i < 200; ++i) pool.run(17, [&](std::uint32_t) { ++sums[c]; });
    });
  }
  for (std::thread& caller : callers) caller.join();
  for (const auto& sum : sums) EXPECT_EQ(sum, 3400);
}

}  // namespace
}  // namespace diaphane::render
