#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <mutex>
#include <thread>
#include <vector>

namespace diaphane::render {

/// Threads that stay, for loops of independent pieces of work. The caller works too, so a pool of n
/// threads starts n - 1. Loops of several callers go on at once: each caller works on its own, and
/// the pool's threads go where the fewest are, so that they take pieces of all.
class ThreadPool {
 public:
  /// 0: as many as the machine has cores.
  explicit ThreadPool(unsigned threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  unsigned threads() const { return static_cast<unsigned>(workers_.size()) + 1; }

  /// Calls `work(i)` once for each i in [0, count), in any order, and returns when all are done.
  /// `before_each`, if any, is asked on the calling thread alone before each of its pieces; true
  /// leaves out what is not yet begun, and the result is false. `work` must not throw.
  bool run(std::uint32_t count, const std::function<void(std::uint32_t)>& work,
           const std::function<bool()>& before_each = nullptr);

 private:
  struct Loop {
    const std::function<void(std::uint32_t)>& work;
    std::uint32_t count;
    std::atomic<std::uint32_t> next{0};
    std::atomic<bool> stopped{false};
    unsigned busy = 0;  // workers in it
    std::condition_variable end{};

    bool open() const { return !stopped && next < count; }
  };

  void worker();
  Loop* open_loop();  // under the lock: the one with the fewest workers
  static void take_pieces(Loop& loop, const std::function<bool()>& before_each);

  std::mutex mutex_;
  std::condition_variable begin_;
  std::list<Loop*> loops_;  ///< on their callers' stacks
  bool closing_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace diaphane::render
