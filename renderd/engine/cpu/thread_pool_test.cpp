#include "renderd/engine/cpu/thread_pool.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <atomic>
#include <barrier>
#include <chrono>
#include <latch>
#include <thread>
#include <vector>

namespace diaphane::render {
namespace {

TEST(ThreadPool, RunsEachPieceOnce) {
  ThreadPool pool(4);
  for (const std::uint32_t count : {0u, 1u, 3u, 64u, 1000u}) {
    std::vector<std::atomic<int>> calls(count);
    EXPECT_EQ(pool.run(count, [&](std::uint32_t i) { ++calls[i]; }), count);
    for (const auto& each : calls) EXPECT_EQ(each, 1);
  }
}

TEST(ThreadPool, StoppedLoopContinuesWithThePiecesThatHaveNotStarted) {
  for (const unsigned threads : {1u, 3u}) {
    ThreadPool pool(threads);
    constexpr std::uint32_t kPieces = 100000;
    std::vector<std::atomic<int>> calls(kPieces);
    std::atomic<bool> begun{false};
    const auto piece = [&](std::uint32_t i) {
      ++calls[i];
      begun = true;
    };
    const std::uint32_t next = pool.run(kPieces, piece, [&] { return begun.load(); });
    // Other threads may do all pieces before the caller asks.
    if (threads == 1) {
      EXPECT_LT(next, kPieces);
    }
    for (std::uint32_t i = 0; i < kPieces; ++i) ASSERT_EQ(calls[i], i < next ? 1 : 0);
    EXPECT_EQ(pool.run(kPieces, piece, nullptr, 0, next), kPieces);
    for (const auto& each : calls) EXPECT_EQ(each, 1);
  }
}

TEST(ThreadPool, LoopsOfTwoCallersRunConcurrently) {
  // The pool has no threads of its own, so only the callers work.
  ThreadPool pool(1);
  std::latch both(2);
  const auto loop = [&] { pool.run(1, [&](std::uint32_t) { both.arrive_and_wait(); }); };
  std::thread other(loop);
  loop();
  other.join();
}

constexpr std::uint32_t kEndless = 1u << 30;

/// A loop on a separate thread. Its pieces are short, so that it pauses quickly.
struct BackgroundLoop {
  BackgroundLoop(ThreadPool& pool, std::uint32_t pieces, unsigned precedence = 0)
      : thread([this, &pool, pieces, precedence] {
          const std::uint32_t next = pool.run(
              pieces,
              [this](std::uint32_t) {
                ++begun;
                ++ended;
              },
              [this] {
                ++asked;
                return stop.load();
              },
              precedence);
          finished = next == pieces;
        }) {
    while (begun == 0) std::this_thread::yield();
  }
  /// Returns whether another piece begins within 30 ms.
  bool goes_on() const {
    const int before = begun;
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    return begun != before;
  }

  std::atomic<int> begun{0}, ended{0}, asked{0};
  std::atomic<bool> stop{false}, finished{false};
  std::thread thread;
};

TEST(ThreadPool, PausesLoopsOfLowerPriority) {
  for (const unsigned threads : {1u, 3u}) {
    ThreadPool pool(threads);
    BackgroundLoop other(pool, kEndless, 2);
    bool went_on = true;
    EXPECT_TRUE(pool.run(
        1,
        [&](std::uint32_t) {
          // On each thread, a piece that is already running may end first.
          for (int i = 0; i < 100 && went_on; ++i) went_on = other.goes_on();
        },
        nullptr, 3));
    EXPECT_FALSE(went_on) << threads;
    other.stop = true;
    other.thread.join();
  }
}

TEST(ThreadPool, DoesNotPauseLoopsOfHigherPriority) {
  ThreadPool pool(1);
  BackgroundLoop other(pool, kEndless, 3);
  bool went_on = false;
  std::thread lower([&] {
    pool.run(
        1, [](std::uint32_t) {}, nullptr, 2);
  });
  for (int i = 0; i < 100 && !went_on; ++i) went_on = other.goes_on();
  EXPECT_TRUE(went_on);
  other.stop = true;
  other.thread.join();
  lower.join();
}

TEST(ThreadPool, PausedLoopEndsWhenStopped) {
  ThreadPool pool(1);
  BackgroundLoop other(pool, kEndless);
  EXPECT_TRUE(pool.run(
      1,
      [&](std::uint32_t) {
        other.stop = true;
        other.thread.join();
      },
      nullptr, 1));
  EXPECT_FALSE(other.finished);
  EXPECT_EQ(other.begun, other.ended);
}

TEST(ThreadPool, PausedLoopResumes) {
  ThreadPool pool(2);
  constexpr int kPieces = 1 << 20;
  BackgroundLoop other(pool, kPieces);
  EXPECT_TRUE(pool.run(
      10, [](std::uint32_t) {}, nullptr, 1));
  other.thread.join();
  EXPECT_TRUE(other.finished);
  EXPECT_EQ(other.ended, kPieces);
}

TEST(ThreadPool, RaisedLoopResumes) {
  for (const unsigned threads : {1u, 3u}) {
    ThreadPool pool(threads);
    constexpr std::uint32_t kPieces = 1000;
    std::atomic<unsigned> precedence{0};
    std::atomic<std::uint32_t> begun{0}, done{0};
    std::latch paused(1);
    std::thread raised([&] {
      EXPECT_TRUE(pool.run(
          kPieces,
          [&](std::uint32_t) {
            ++begun;
            paused.wait();
            ++done;
          },
          nullptr, precedence));
    });
    while (begun == 0) std::this_thread::yield();
    EXPECT_TRUE(pool.run(
        1,
        [&](std::uint32_t) {
          paused.count_down();
          std::this_thread::sleep_for(std::chrono::milliseconds(20));
          EXPECT_LT(done, kPieces) << "each thread ends one piece and pauses";
          pool.raise(precedence, 5);
          while (done < kPieces) std::this_thread::yield();
        },
        nullptr, 3));
    raised.join();
  }
}

TEST(ThreadPool, RaisingNeverLowers) {
  ThreadPool pool(1);
  std::atomic<unsigned> precedence{4};
  pool.raise(precedence, 2);
  EXPECT_EQ(precedence, 4U);
}

/// Returns the nice value of the pool's thread in a loop whose caller has `nice`.
int nice_in_loop(ThreadPool& pool, int nice, unsigned precedence) {
  std::atomic<int> found{-20};
  std::thread caller([&] {
    (void)setpriority(PRIO_PROCESS, 0, nice);
    const std::thread::id own = std::this_thread::get_id();
    std::barrier both(2);  // the caller and the pool's thread have one piece each
    pool.run(
        2,
        [&](std::uint32_t) {
          if (std::this_thread::get_id() != own) found = getpriority(PRIO_PROCESS, 0);
          both.arrive_and_wait();
        },
        nullptr, precedence);
  });
  caller.join();
  return found;
}

TEST(ThreadPool, ThreadsForPrecedenceZeroTakeOverTheNiceValueOfTheCaller) {
  const int own = getpriority(PRIO_PROCESS, 0);
  const int nice = std::min(own + 5, 19);
  ThreadPool pool(2);
  EXPECT_EQ(nice_in_loop(pool, nice, 1), own) << "threads for urgent loops keep theirs";
  EXPECT_EQ(nice_in_loop(pool, nice, 0), nice);
}

TEST(ThreadPool, RunsEachPieceOfConcurrentCallersOnce) {
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
